#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "genus/boolean/exact_point.h"
#include "genus/boolean/plates.h"
#include "genus/boolean/soup.h"

namespace genus::exact {

/// Pairs of plates of a soup that may meet, found by their boxes and planes. One face stands for
/// each.
struct Candidates {
    PlateTree tree;
    std::vector<BoxTree::Pair> pairs;
    bool complete = true;  // false: more than `most` are of two operands, and none is listed
};
/// `owners` as from find_owners.
Candidates find_candidates(const Soup& soup, std::vector<std::int32_t> owners, std::size_t most);

/// The faces of a soup, cut along all their intersections, so that any two cells meet in common
/// corners and edges only and no two cover each other.
///
/// Faces that nothing touches are not looked at: they stay `passive`. All others are covered by
/// cells. Coplanar faces that overlap share their cells; `covers` says which faces lie over a
/// cell.
struct Arrangement {
    struct Cover {
        std::int32_t face;
        std::int32_t sign;  // 1 if the face turns like the cell's plane, else -1
    };
    struct Cell {
        Triangle corners;    // turn like `plane`
        std::int32_t plane;  // a face of the soup in the same plane
        /// The cell across edge i, if nothing else meets that edge and the same covers that cell.
        std::array<std::int32_t, 3> across{-1, -1, -1};
        std::int32_t covers_begin;
        std::int32_t covers_end;
    };

    std::vector<PointRef> points;  // those of the soup, then those of intersections
    std::deque<ExactPoint> exact;
    std::vector<std::int32_t> first_equal;  // each point of the soup: the point that stands for it
    std::vector<char> passive;              // each face of the soup
    std::vector<Cell> cells;
    std::vector<Cover> covers;
    std::vector<std::int32_t> first_cell;  // each face: a cell over it; -1 if passive
    std::vector<std::int32_t> group_end;   // each cell: end of the cells of its plane's group

    PlateTree tree;
    /// Faces that are neither passive nor covered by cells, see buried.h; empty for none.
    std::vector<char> buried;

    /// Operands two faces of which meet in more than what they have in common; repeated.
    std::vector<std::int32_t> touch_themselves;

    std::int64_t n_candidate_pairs = 0;
    std::int64_t n_contacts = 0;
};

/// Implements [cherchi2020]: intersections found face by face, each face cut on its own, with
/// common points made equal by exact comparison. Departs from it where coplanar faces overlap:
/// they are cut together; and where something crosses the edge between two faces of one operand
/// and one plane: they are cut as one, without that edge.
///
/// Faces that are `buried`, which may be empty, take no part. Time grows with the boxes that
/// overlap. Throws Error if operands cross themselves that were
/// declared not to.
Arrangement arrange(const Soup& soup, Candidates candidates, std::vector<char> buried);

}  // namespace genus::exact
