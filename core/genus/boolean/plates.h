#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "genus/boolean/box_tree.h"
#include "genus/boolean/contact.h"
#include "genus/boolean/soup.h"

namespace genus::exact {

/// The halfedges round a plate, counterclockwise; corner i is where halfedge i starts.
struct Outline {
    int n;
    std::array<std::int32_t, 4> halfedge;
};

/// The faces of a soup, two at a time where they make a strictly convex quadrangle of one plane: a
/// plate is what contacts are looked for between, for two quadrangles meet once where their
/// triangles meet up to four times. A face that finds no other is a plate by itself.
class Plates {
public:
    Plates() = default;
    /// Faces of one plate have one owner, see charts.h. Exact. O(faces).
    Plates(const Soup& soup, const std::vector<std::int32_t>& owners);

    /// The halfedge of f that parts the faces of its plate, or -1.
    std::int32_t diagonal(std::int32_t f) const { return diagonal_.empty() ? -1 : diagonal_[f]; }
    /// The other face of a plate, or -1.
    std::int32_t other(const Soup& soup, std::int32_t f) const
    {
        const std::int32_t h = diagonal(f);
        return h < 0 ? -1 : soup.twin[h] / 3;
    }
    Outline outline(const Soup& soup, std::int32_t f) const;
    /// With corners numbered as in the soup.
    Corners corners(const Soup& soup, std::int32_t f) const
    {
        return diagonal(f) < 0 ? corners_of(soup, f) : quadrangle(soup, f);
    }

    bool empty() const { return diagonal_.empty(); }

private:
    Corners quadrangle(const Soup& soup, std::int32_t f) const;

    std::vector<std::int32_t> diagonal_;  // by face; empty if no plate has two
};

/// Do the faces on the two sides of a halfedge lie in one plane and turn alike? Exact.
bool same_plane(const Soup& soup, std::int32_t h);

/// In place of the owner of a face that meets no other for sure.
inline constexpr std::int32_t kNotSought = -2;

/// A tree over the plates of a soup. The lower of its faces stands for a plate.
class PlateTree {
public:
    PlateTree() = default;
    /// `owners` as from find_owners; faces of kNotSought are left out.
    PlateTree(const Soup& soup, std::vector<std::int32_t> owners);
    /// Each face a plate by itself, for those to whom pairs are known already.
    static PlateTree of_faces(const Soup& soup);

    const Plates& plates() const { return plates_; }

    /// Calls visit(f, g, part) for pairs of plates, as BoxTree::visit_pairs.
    template <class Prepare, class Visit>
    void visit_pairs(const Prepare& prepare, const Visit& visit) const
    {
        tree_.visit_pairs(prepare, [&](std::int32_t a, std::int32_t b, std::size_t part) {
            visit(face(a), face(b), part);
        });
    }
    /// Calls visit(f) for all faces of plates whose box overlaps `box`.
    template <class Visit>
    void query(const Soup& soup, const FloatBox& box, const Visit& visit) const
    {
        tree_.query(box, [&](std::int32_t item) {
            const std::int32_t f = face(item);
            visit(f);
            if (const std::int32_t g = plates_.other(soup, f); g >= 0) visit(g);
        });
    }

private:
    /// The boxes of all plates, in order.
    std::vector<FloatBox> boxes(const Soup& soup) const;
    std::int32_t face(std::int32_t item) const { return face_.empty() ? item : face_[item]; }

    Plates plates_;
    std::vector<std::int32_t> face_;  // of each item; empty if each face is one
    BoxTree tree_;
};

}  // namespace genus::exact
