#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "genus/boolean/arrangement.h"
#include "genus/boolean/winding.h"

namespace genus::exact {

/// A face of a result, outward side counterclockwise.
struct OutFace {
    Triangle corners;     // numbers of points of the arrangement
    std::int32_t plane;   // a face of the soup in the same plane
    std::int32_t source;  // the face of the soup it stands for
    bool flipped;         // turns against `plane`
    bool fixed;           // not to be joined with others of its plane
    bool untouched;       // a passive face of the soup, as it was
    /// Of a cell of the arrangement: its number, else -1.
    std::int32_t cell = -1;
};

/// The selected faces as a closed oriented surface. Pieces of one plane that meet along an edge
/// of exactly two faces are joined where `merge_coplanar`: corners that no other plane needs are
/// left out and the piece is triangulated anew.
std::vector<OutFace> collect_faces(const Soup& soup, const Arrangement& arrangement,
                                   const Selection& selection, bool merge_coplanar);

/// A surface with its own numbers for corners, manifold: where faces touch along an edge or in a
/// corner without being neighbours round the solid, each part has a corner of its own. Where two
/// parts would still share both ends of an edge, the edge gets a corner in the middle, rounded to
/// the grid, for each of them: the arrangement's points and `faces` then grow.
struct OutMesh {
    std::vector<Triangle> faces;       // in the order of the OutFaces
    std::vector<std::int32_t> points;  // of each corner: its number in the arrangement
    /// The first points are those at which only untouched faces end, in the order of these.
    std::size_t n_plain_points = 0;
};
/// Nothing if an edge has no room for one; `place` is a point of it then.
std::optional<OutMesh> split_to_manifold(const Soup& soup, Arrangement& arrangement,
                                         std::vector<OutFace>& faces, Vec3& place);

}  // namespace genus::exact
