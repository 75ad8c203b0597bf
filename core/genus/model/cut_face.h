#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "genus/mesh/indexed_mesh.h"
#include "genus/model/coarse_shell.h"
#include "genus/model/surface_form.h"

namespace genus {

/// A vertex of a face that is cut.
struct FinePoint {
    Vec3 at;
    /// Along which the surfaces that meet there recede by its length of 1.
    Vec3 direction;
    /// Where in its face of the coarse mesh it came from: the weights of the second and the third
    /// corner.
    Weights place{};
    /// The largest offset along `direction`, as a share of what it is where that has length 1.
    double room = 1.0;
};

/// Pieces into which a chord of this sagitta must go; the sagitta falls with their square.
double pieces_for(double sagitta, double limit);

/// Cuts faces of a coarse mesh, points on their borders given, into faces so near their surface
/// that they clear it where each corner moves outward, or inward, by `limit` times its room.
///
/// A chord with sagitta s is taken to be as long as the square root of s. Where these lengths make
/// a flat triangle, as on a cylinder or in a plane, the face becomes one strip between its longest
/// side and the two others, with no more vertices. Where they make a round one, it gets the points
/// of a regular lattice, as many as triangles with that circumradius need, and strips along its
/// sides. Between the two, the side with the most points is cut in its middle, the cut leads to the
/// opposite corner, and both halves are cut in turn. Faces that come out too far from the surface
/// are mended by a vertex on their longest edge or in their middle. If faces come out turned over,
/// or too many need that, the whole face is cut in halves only.
///
/// O(triangles made).
class CutFace {
public:
    CutFace(double limit, std::int64_t max_triangles);

    /// Cuts the next face: on a surface, turned against its gradient or not; with the vertices of
    /// its border, corner after corner, the number of pieces of each side, and whether one of these
    /// follows a curve where surfaces meet. False if a point cannot be put on the surface.
    bool run(const SurfaceForm& form, bool turned, const std::vector<FinePoint>& border,
             const std::array<std::int32_t, 3>& pieces, bool any_curve);

    /// Those of the border come first.
    const std::vector<FinePoint>& points() const { return points_; }
    const std::vector<Triangle>& faces() const { return faces_; }
    /// How far each of the points is to move outward and inward for its faces to clear their
    /// surface, about.
    const std::vector<std::array<double, 2>>& reaches() const { return reaches_; }
    std::int32_t n_border() const { return n_border_; }

private:
    // Vertices pool_[begin] .. pool_[begin + n], or backwards from pool_[begin].
    struct Side {
        std::int32_t begin = 0, n = 1, step = 1;
        std::int32_t at(const std::vector<std::int32_t>& pool, std::int32_t k) const
        {
            return pool[begin + step * k];
        }
        Side part(std::int32_t from, std::int32_t to) const
        {
            return {begin + step * from, to - from, step};
        }
        Side turned() const { return {begin + step * n, n, -step}; }
    };
    struct Lattice;
    // Lengths in radii.
    struct MetricShape {
        double height = 0.0, radius = 0.0;
        bool is_round = false;
    };

    bool fill(const std::array<Side, 3>& sides, int depth);
    bool fill_halves(const std::array<Side, 3>& sides, std::size_t most, int depth);
    bool fill_lattice(const std::array<Side, 3>& sides, std::int32_t n);
    bool place_lattice(const std::array<Side, 3>& sides, std::int32_t n);
    void add_points(const TwoVec& p, const std::array<Weights, 2>& places);
    void add_one_by_one(const Lattice& l);
    void add_in_pairs(const Lattice& l);
    void add_pair(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d,
                  std::int32_t begin);
    void fill_rim(const std::array<Side, 3>& sides, const Lattice& lattice);
    void fill_strip(const Side& upper, const Side& lower);
    void fill_thin(const std::array<Side, 3>& sides, std::size_t most);
    std::int32_t lattice_for(const std::array<Side, 3>& sides, const MetricShape& shape) const;
    std::optional<double> lattice_radius(const std::array<Side, 3>& sides, double u, double v,
                                         double step) const;
    MetricShape metric_shape(const std::array<Side, 3>& sides) const;
    Vec3 swept(const std::array<Side, 3>& sides, double u, double v) const;
    std::optional<Side> new_side(std::int32_t a, std::int32_t b, double widest);
    std::optional<std::int32_t> on_surface(const Vec3& start, const Vec3& way,
                                           const Weights& place);
    bool too_many() const { return static_cast<std::int64_t>(faces_.size()) > max_triangles_; }
    void add(const Triangle& t);
    void judge(std::int32_t f);
    bool mend();
    void find_reaches();
    std::int32_t face_across(std::int32_t f, std::int32_t a, std::int32_t b) const;
    std::array<double, 2> own_distance(const Vec3& a, const Vec3& b, const Vec3& c,
                                       double slope) const;
    bool clears(const Triangle& t, std::size_t side) const;
    double chord_length(std::int32_t a, std::int32_t b) const;
    std::array<double, 2> chord_lengths(const std::array<std::int32_t, 2>& one,
                                        const std::array<std::int32_t, 2>& other) const;

    const SurfaceForm* form_ = nullptr;
    double sign_ = 1.0, limit_ = 0.0, full_limit_;
    bool any_curve_ = false, only_halves_ = false, turned_over_ = false;
    std::int64_t max_triangles_;
    std::vector<FinePoint> points_;
    std::vector<Triangle> faces_;
    std::vector<std::array<double, 2>> distances_, reaches_;
    std::vector<double> slopes_;  // of the surface at the points of the lattice
    std::vector<std::int32_t> pool_, too_far_;
    std::int32_t n_border_ = 0;
};

}  // namespace genus
