#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "genus/base/box.h"
#include "genus/base/interval.h"
#include "genus/mesh/indexed_mesh.h"
#include "genus/patch/bspline.h"
#include "genus/patch/tessellate.h"

namespace genus {

/// A matrix by columns.
using Columns3 = std::array<Vec3, 3>;

/// What is known about folds of a deformation: places where it turns space inside out.
struct FoldReport {
    enum class Kind {
        None,    ///< the Jacobian determinant is positive on the whole lattice: locally invertible
        Folded,  ///< it is negative at `where`
        Undecided  ///< it comes so close to zero that rounding or the budget left it open
    };
    Kind kind = Kind::None;
    Vec3 where;                // a point with negative determinant, before the deformation
    double determinant = 0.0;  // Folded: at `where`; None: a lower bound
};

/// Whether a deformation takes two points to one place.
struct OneToOneReport {
    enum class Kind {
        Yes,       ///< proven that it does not
        No,        ///< it does: `points` are two, far apart beside `bound`
        Undecided  ///< the budget left it open; `points` are places it came down to
    };
    Kind kind = Kind::Yes;
    std::array<Vec3, 2> points;  // before the deformation
    double bound = 0.0;  // No: the exact second point is within this of points[1], model units
};

struct InversePoint {
    Vec3 point;  // apply(point) is the point asked for
    bool found = false;
    bool certified = false;  // an interval test proves a unique solution within `bound` of `point`
    double bound = 0.0;      // model units
    int steps = 0;           // of Newton
};

/// Free-form deformation by a lattice of control points over a parallelepiped
/// origin + s a + t b + u c with s, t, u in [0, 1]. Points outside stay where they are.
///
/// The map is x + sum B_i(s) B_j(t) B_k(u) d_ijk with d_ijk the moves of the control points away
/// from their places in the undeformed lattice, which is the form of the book up to rounding: the
/// undeformed lattice is then the identity to the last bit, and a lattice whose outer k + 1 layers
/// do not move is C^k across its border. (A B-spline lattice of degree p at most C^(p-1).)
///
/// Control points of curves and patches may be deformed in place of the points; that is exact for
/// affine deformations only. The exact image of a curve of degree n under Bernstein degrees
/// (l, m, k) has degree n (l + m + k).
///
/// Implements [sederberg1986].
class Lattice {
public:
    /// Bernstein lattice of degree (l, m, n) with (l + 1) (m + 1) (n + 1) control points.
    /// Throws InvalidInput unless the axes are finite and independent (scaled condition below
    /// 1e12), degrees in [1, 64], and at most 2^22 points.
    Lattice(const Vec3& origin, const Columns3& axes, const std::array<int, 3>& degree);
    /// B-spline lattice of degree `degree` in all directions, with clamped uniform knots and
    /// `counts` control points. Degrees up to 15.
    static Lattice bspline(const Vec3& origin, const Columns3& axes,
                           const std::array<int, 3>& counts, int degree = 3);
    /// Bernstein lattice over a box.
    static Lattice over(const Box3& box, const std::array<int, 3>& degree);

    const Vec3& origin() const { return origin_; }
    const Columns3& axes() const { return axes_; }
    const std::array<int, 3>& counts() const { return counts_; }
    bool is_bspline() const { return !knots_.empty(); }
    int degree(int axis) const;
    std::size_t n_points() const { return moves_.size(); }
    std::size_t index(int i, int j, int k) const
    {
        const auto [l, m, n] = counts_;
        static_cast<void>(l);
        return (static_cast<std::size_t>(i) * static_cast<std::size_t>(m) +
                static_cast<std::size_t>(j)) *
                   static_cast<std::size_t>(n) +
               static_cast<std::size_t>(k);
    }
    /// Where control point (i, j, k) stands in the undeformed lattice, and now.
    Vec3 rest(int i, int j, int k) const;
    Vec3 point(int i, int j, int k) const { return rest(i, j, k) + moves_[index(i, j, k)]; }
    void set_point(int i, int j, int k, const Vec3& p);
    /// All control points, (i, j, k) at index(i, j, k).
    std::vector<Vec3> points() const;
    void set_points(std::span<const Vec3> points);
    const std::vector<Vec3>& moves() const { return moves_; }
    /// The same map, number by number.
    bool same(const Lattice& other) const
    {
        return origin_ == other.origin_ && axes_ == other.axes_ && counts_ == other.counts_ &&
               knots_ == other.knots_ && moves_ == other.moves_;
    }
    /// Throws InvalidInput for another number or a move that is not finite.
    void set_moves(std::vector<Vec3> moves);
    /// Puts the outer k + 1 layers back, which makes the deformation C^k across the border.
    void keep_border(int k);
    /// The largest k for which `keep_border(k)` would change nothing; -1 if the outer layer moved.
    int border_continuity() const;

    /// (s, t, u) of a point. A point that is outside by no more than rounding is on the border.
    Vec3 local(const Vec3& x) const;
    Vec3 global(const Vec3& stu) const;

    Vec3 apply(const Vec3& x) const;
    /// Many points, vectorised for Bernstein lattices; `out` may be `x`. Throws InvalidInput if
    /// the sizes differ. Rounding errors below `rounding()`.
    void apply(std::span<const Vec3> x, std::span<Vec3> out) const;
    double rounding() const;
    /// Derivative of the map at x: column a is that along coordinate axis a. Identity outside.
    Columns3 jacobian(const Vec3& x) const;

    /// A box that holds the image of a box, from control points of the parts of the lattice in it.
    Box3 image_bounds(const Box3& x) const;
    /// The same for a box of (s, t, u) in [0, 1].
    Box3 image_of_local(const Box3& stu) const;
    /// The map stretches no distance inside a convex set within `x` by more than this.
    double stretch(const Box3& x) const;
    /// Bounds of the second derivatives by (s, t, u) on n^3 boxes that halve, third, .. the
    /// lattice: entry (i n + j) n + k has those by ss, tt, uu, st, tu, us on box (i, j, k). A
    /// triangle that spans S, T, U there is within (ss S^2 + .. + 2 st S T + ..) / 8 of its image.
    std::vector<std::array<double, 6>> second_bounds(int n) const;
    /// Parameters, each in (0, 1) along `axis`, where the map may be less than C^1.
    std::vector<double> kinks(int axis) const;

    /// Sign of the Jacobian determinant over the whole lattice, from its Bernstein coefficients on
    /// boxes that are halved until they agree in sign. `max_boxes` bounds the work.
    FoldReport folds(int max_boxes = 20000) const;

    /// Whether two points of a box of space, as far as it lies in the lattice, are taken to one
    /// place. Where the Jacobian determinant keeps its sign all over the box, the map is one to one
    /// if it is on the surface of the box: every point then counts the same in the degree of the
    /// map, which is that of its boundary. Rectangles of the surface are compared in pairs, and
    /// their halves, until a plane separates their images, or all differences of the map over the
    /// hull of both are matrices about one that can be inverted. Points that meet are found by
    /// Newton's method and proven by Krawczyk's test.
    ///
    /// Implements [meisters1963] (from the boundary to the whole).
    /// `max_pairs` bounds the work: about 10 microseconds each, for pairs of a cubic lattice; one
    /// of 16^3 points counts 64 of them.
    OneToOneReport one_to_one(const Box3& x, int max_pairs = 200000) const;

    /// The point that the deformation takes to y: Newton's method from y, then from boxes whose
    /// hull of control points holds y; existence and uniqueness nearby by Krawczyk's test.
    /// Of several solutions (a folded lattice) one is returned. Points that no point of the
    /// lattice reaches come back as themselves if they are outside, else not found.
    /// Implements [krawczyk1969].
    InversePoint inverse(const Vec3& y) const;

    /// The same without a proof and without a search: Newton's method from x.
    std::optional<Vec3> solve(const Vec3& y, const Vec3& x) const;

    /// The weights B_i B_j B_k of all control points at x, or of their directional derivative
    /// along `direction` (model units); all zero outside.
    std::vector<double> weights(const Vec3& x,
                                const std::optional<Vec3>& direction = std::nullopt) const;

private:
    struct Piece;

    Lattice(const Vec3& origin, const Columns3& axes, const std::array<int, 3>& counts,
            std::vector<KnotVector> knots);
    struct AxisBasis {
        int first;
        std::vector<double> value, slope;
    };
    AxisBasis axis_basis(int axis, double t, bool with_slope) const;
    std::vector<Piece> pieces() const;
    Columns3 local_derivative(const Vec3& stu) const;
    Box3 local_box(const Box3& x) const;
    std::array<IntervalVec3, 3> derivative_bounds(const std::vector<Piece>& pieces,
                                                  const Box3& stu) const;
    double local_determinant(const Vec3& stu) const;
    FoldReport folds_in(const Box3& stu, double sign, int max_boxes) const;
    bool folds_by_coefficients(const Piece& piece, const Box3& box, double sign, int& max_boxes,
                               FoldReport& report) const;
    bool folds_by_slopes(const std::vector<Piece>& pieces, const Box3& box, double sign,
                         int& max_boxes, FoldReport& report) const;
    double least_determinant(const std::vector<Piece>& pieces, const Box3& stu) const;
    OneToOneReport meeting_at_fold(const Box3& stu, const Vec3& positive,
                                   const Vec3& negative) const;
    std::optional<OneToOneReport> meeting(const Box3& stu, const Vec3& p, const Vec3& start) const;
    class Surface;
    std::optional<Vec3> newton(const Vec3& y, Vec3 stu, int& steps) const;
    double certify(const Vec3& y, const Vec3& stu) const;

    Vec3 origin_;
    Columns3 axes_, inverse_axes_;
    Vec3 slack_;  // rounding of `local`
    std::array<int, 3> counts_;
    std::vector<KnotVector> knots_;  // three, or none for Bernstein
    std::vector<Vec3> moves_;
};

IndexedMesh deformed(IndexedMesh mesh, const Lattice& lattice);
PolygonMesh deformed(PolygonMesh mesh, const Lattice& lattice);
// By their control points, see Lattice.
BezierCurve deformed(const BezierCurve& curve, const Lattice& lattice);
BSpline deformed(const BSpline& curve, const Lattice& lattice);
TensorPatch deformed(const TensorPatch& patch, const Lattice& lattice);
BezierTriangle deformed(const BezierTriangle& patch, const Lattice& lattice);
BSplineSurface deformed(const BSplineSurface& surface, const Lattice& lattice);

}  // namespace genus
