#include "genus/model/certificate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "genus/base/halves.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/mesh/aabb_tree.h"
#include "genus/model/fans.h"

namespace genus {

namespace {

constexpr std::size_t kGroupFaces = 24;
constexpr int kMaxRounds = 24;
constexpr double kGrowth = 1.25;
constexpr double kUpTo = 1.0 - 0x1p-50;         // of the tolerance, rounding allowed for
constexpr double kSmallFace = 0.25;             // diagonal, of the tolerance
constexpr int kLarge = 4;                       // beside the bits of the two sides
constexpr double kSmallBox = 1.0 / 16.0;        // radius, of the tolerance
constexpr double kSmallestBox = 1.0 / 4096.0;   // radius, of the tolerance
constexpr double kLargestShare = 0.125;         // radius of a box that may lie in a sandwich
constexpr double kBeside = 5.0;                 // reach of a direction, of the thickness
constexpr double kFlatness = 0.1;               // of a sandwich, of the shortest edge
constexpr double kSmallestShare = 1.0 / 256.0;  // radius of a box that must lie in one
constexpr std::int64_t kMaxListed = 256;
constexpr std::int64_t kMaxBoxes = 2'000'000, kMaxBoxesStrict = 400'000;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Faces near each other with the formula cut down to the surfaces that decide near them.
struct Group {
    std::vector<std::int32_t> faces;
    SignFormula formula;
};

template <class Simplex>
void find_signs(const SignFormula& formula, const std::vector<SurfaceForm>& forms,
                const Simplex& simplex, std::vector<Sign>& signs)
{
    for (const std::int32_t s : formula.surfaces()) {
        const Interval range = forms[s].range(simplex);
        signs[s] = range.lo > 0.0 ? Sign{1} : range.hi < 0.0 ? Sign{-1} : Sign{0};
    }
}

// The way from mesh to surface: the meshes M+ and M-.
class Shell {
public:
    // `least`: how far M+ and M- are to be from the faces at least, about.
    Shell(const SurfaceMesh& mesh, const SignFormula& formula,
          const std::vector<SurfaceForm>& forms, double tolerance, double least)
        : m_(mesh), forms_(forms), tolerance_(tolerance), least_(least)
    {
        take_apart();
        make_groups(formula);
        note_labels();
        first_offsets();
    }

    // Widens the shell where signs are not shown yet, until they are or the tolerance is passed.
    void grow()
    {
        const std::size_t n = m_.mesh.n_faces();
        std::vector<char> pending(n, 1);
        for (int round = 0; round < kMaxRounds; ++round) {
            current_progress().check();
            check_faces(pending);
            bool any = false;
            std::vector<char> touched(points_.size(), 0);
            for (std::size_t f = 0; f < n; ++f) {
                pending[f] = 0;
                if (open_[f] == 0) continue;
                const bool small =
                    face_box(static_cast<std::int32_t>(f)).diagonal() <= kSmallFace * tolerance_;
                for (const int side : {0, 1})
                    for (const std::int32_t v : face(f, side))
                        touched[v] = static_cast<char>(touched[v] | (open_[f] & (1 << side)) |
                                                       (small ? 0 : kLarge));
            }
            std::vector<char> changed(points_.size(), 0);
            for (std::size_t v = 0; v < touched.size(); ++v)
                if ((touched[v] & 3) != 0 && widen(static_cast<std::int32_t>(v), touched[v])) {
                    changed[v] = 1;
                    any = true;
                }
            if (!any) return;
            for (std::size_t f = 0; f < n; ++f)
                for (const int side : {0, 1})
                    for (const std::int32_t v : face(f, side)) pending[f] |= changed[v];
        }
    }

    IndexedMesh moved(int side) const
    {
        IndexedMesh result{points_, faces(side)};
        for (std::size_t v = 0; v < result.n_vertices(); ++v)
            result.vertices[v] = corner(static_cast<std::int32_t>(v), side);
        return result;
    }

    void report(Certificate& c, bool strict) const
    {
        for (std::size_t v = 0; v < offset_.size(); ++v) {
            const double length = norm(direction_[v]);
            const double share = std::max(offset_[v][0], offset_[v][1]) * length;
            c.bound = std::max(c.bound, share);
            double& part = n_labels_[v] > 1 ? c.creases : c.faces;
            part = std::max(part, share);
            c.rounding = std::max(c.rounding, rounding_[v] * length);
        }
        // A face without signs will do if it is so near a good face that that speaks for it.
        const std::vector<double> good = strict ? std::vector<double>{} : far_from_surface();
        for (std::size_t f = 0; f < open_.size(); ++f) {
            const auto face = static_cast<std::int32_t>(f);
            if (open_[f] == 0 ? reach(face) <= tolerance_
                              : !strict && vouched_for(face, good, c.bound))
                continue;
            ++c.n_failed;
            c.failed_faces.push_back(face);
            if (static_cast<std::int64_t>(c.failed.size()) < kMaxListed)
                c.failed.push_back(face_box(face));
        }
    }

    // Boxes of the faces of M+ and M- that are not known to lie outside and inside.
    std::vector<Box3> open_boxes() const
    {
        std::vector<Box3> boxes;
        for (std::size_t f = 0; f < open_.size(); ++f)
            for (const int side : {0, 1}) {
                if ((open_[f] >> side & 1) == 0) continue;
                Box3 box;
                for (const std::int32_t v : face(f, side)) box.add(corner(v, side));
                boxes.push_back(box);
            }
        return boxes;
    }

private:
    // The most that a corner of the face moves. A face keeps its own error from this as long as
    // its neighbours are no worse.
    double reach(std::int32_t f) const { return std::max({reach(f, 0), reach(f, 1), reach(f, 2)}); }
    double reach(std::size_t f, std::size_t i) const
    {
        const std::int32_t out = face(f, 0)[i], in = face(f, 1)[i];
        return std::max(offset_[out][0] * norm(direction_[out]),
                        offset_[in][1] * norm(direction_[in]));
    }

    // How far a vertex is from the surface at most: so much as it moves in a face with signs, or
    // as the way along edges to one that does.
    std::vector<double> far_from_surface() const
    {
        std::vector<double> far(m_.mesh.n_vertices(), kInfinity);
        std::vector<std::size_t> open;
        for (std::size_t f = 0; f < open_.size(); ++f) {
            if (open_[f] != 0) open.push_back(f);
            for (std::size_t i = 0; i < 3 && open_[f] == 0; ++i) {
                double& least = far[m_.mesh.faces[f][i]];
                least = std::min(least, reach(f, i));
            }
        }
        bool any = !open.empty();
        for (int round = 0; any && round < kMaxRounds; ++round) {
            any = false;
            for (const std::size_t f : open) {
                const std::array<Vec3, 3> p = face_corners(static_cast<std::int32_t>(f));
                for (std::size_t i = 0; i < 3; ++i)
                    for (std::size_t j = 0; j < 3; ++j) {
                        double& least = far[m_.mesh.faces[f][i]];
                        const double by = far[m_.mesh.faces[f][j]] + distance(p[i], p[j]);
                        if (!(by < least)) continue;
                        least = by;
                        any = true;
                    }
            }
        }
        return far;
    }

    bool vouched_for(std::int32_t f, const std::vector<double>& good, double& bound) const
    {
        const std::array<Vec3, 3> p = face_corners(f);
        double least = kInfinity;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::int32_t v = m_.mesh.faces[f][i];
            const double far =
                std::max(distance(p[i], p[(i + 1) % 3]), distance(p[i], p[(i + 2) % 3]));
            least = std::min(least, good[v] + far);
        }
        if (!(least <= tolerance_)) return false;
        bound = std::max(bound, least);
        return true;
    }

    Box3 face_box(std::int32_t f) const
    {
        Box3 box;
        for (const std::int32_t v : m_.mesh.faces[f]) box.add(m_.mesh.vertices[v]);
        return box;
    }

    // Where the mesh touches itself, M+ has its faces together that bound the same wedge of empty
    // space: those of one wedge of matter could not move out of it there.
    void take_apart()
    {
        points_ = m_.mesh.vertices;
        if (m_.touch_of_vertex.empty()) return;
        std::optional<FansOfSpace> fans = fans_of_space(m_);
        if (!fans) return;
        outer_faces_ = std::move(fans->faces);
        for (const std::int32_t v : fans->original) points_.push_back(m_.mesh.vertices[v]);
    }

    const std::vector<Triangle>& faces(int side) const
    {
        return side == 0 && !outer_faces_.empty() ? outer_faces_ : m_.mesh.faces;
    }

    // The corners that a face has in M+ (side 0) or M-.
    const Triangle& face(std::size_t f, int side) const { return faces(side)[f]; }

    void make_groups(const SignFormula& formula)
    {
        struct Task {
            std::vector<std::int32_t> faces;
            SignFormula formula;
            std::vector<Group> groups;
        };
        std::vector<Task> tasks;
        std::vector<std::int32_t> all(m_.mesh.n_faces());
        for (std::size_t f = 0; f < all.size(); ++f) all[f] = static_cast<std::int32_t>(f);
        divide(std::move(all), formula, 4096,
               [&](std::vector<std::int32_t>&& faces, const SignFormula& f) {
                   tasks.push_back({std::move(faces), f, {}});
               });
        parallel_for(tasks.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                divide(std::move(tasks[i].faces), tasks[i].formula, kGroupFaces,
                       [&](std::vector<std::int32_t>&& faces, const SignFormula& f) {
                           tasks[i].groups.push_back({std::move(faces), f});
                       });
        });
        for (Task& task : tasks)
            groups_.insert(groups_.end(), std::make_move_iterator(task.groups.begin()),
                           std::make_move_iterator(task.groups.end()));
        group_of_vertex_.assign(points_.size(), -1);
        for (std::size_t g = 0; g < groups_.size(); ++g)
            for (const std::int32_t f : groups_[g].faces)
                for (const int side : {0, 1})
                    for (const std::int32_t v : face(f, side))
                        if (group_of_vertex_[v] < 0)
                            group_of_vertex_[v] = static_cast<std::int32_t>(g);
    }

    template <class Done>
    void divide(std::vector<std::int32_t>&& faces, const SignFormula& formula, std::size_t enough,
                const Done& done) const
    {
        if (faces.empty()) return;
        Box3 box, centres;
        for (const std::int32_t f : faces) {
            const Box3 b = face_box(f);
            box.add(b);
            centres.add(b.center());
        }
        // Offsets do not exceed the tolerance by more than one step of growth.
        std::vector<Sign> signs(forms_.size(), Sign{0});
        find_signs(formula, forms_, box.inflated(2.0 * tolerance_), signs);
        const SignFormula here = formula.simplified(signs);
        const Vec3 size = centres.size();
        if (faces.size() <= enough || !(std::max({size[0], size[1], size[2]}) > 0.0)) {
            done(std::move(faces), here);
            return;
        }
        const std::size_t axis = longest_axis(size);
        const auto middle = faces.begin() + static_cast<std::ptrdiff_t>(faces.size() / 2);
        const auto key = [&](std::int32_t f) {
            const Box3 b = face_box(f);
            return b.min[axis] + b.max[axis];
        };
        std::nth_element(faces.begin(), middle, faces.end(), [&](std::int32_t a, std::int32_t b) {
            const double ka = key(a), kb = key(b);
            return ka < kb || (ka == kb && a < b);
        });
        std::vector<std::int32_t> second(middle, faces.end());
        faces.erase(middle, faces.end());
        // nth_element leaves an order that depends on the library; the set does not.
        std::sort(faces.begin(), faces.end());
        std::sort(second.begin(), second.end());
        divide(std::move(faces), here, enough, done);
        divide(std::move(second), here, enough, done);
    }

    std::array<std::int32_t, 6> corners_of_both(std::size_t f) const
    {
        const Triangle &out = face(f, 0), &in = face(f, 1);
        return {out[0], out[1], out[2], in[0], in[1], in[2]};
    }

    // The signed surfaces of the faces round each vertex.
    void note_labels()
    {
        labels_.assign(points_.size(), {});
        n_labels_.assign(points_.size(), 0);
        for (std::size_t f = 0; f < m_.mesh.n_faces(); ++f)
            for (const std::int32_t v : corners_of_both(f)) {
                auto& list = labels_[v];
                std::uint8_t& n = n_labels_[v];
                const std::int32_t label = m_.surface_of_face[f];
                if (n < list.size() &&
                    std::find(list.begin(), list.begin() + n, label) == list.begin() + n)
                    list[n++] = label;
            }
    }

    Vec3 outward(std::int32_t label, const Vec3& p) const
    {
        const Vec3 g = forms_[label >> 1].gradient(p);
        return (label & 1) != 0 ? -g : g;
    }

    void first_offsets()
    {
        const std::size_t n = points_.size();
        direction_.resize(n);
        offset_.assign(n, {0.0, 0.0});
        rounding_.assign(n, 0.0);
        parallel_for(n, 1024, [&](std::size_t begin, std::size_t end) {
            std::vector<Sign> signs(forms_.size(), Sign{0});
            for (std::size_t v = begin; v < end; ++v) {
                direction_[v] = choose_direction(static_cast<std::int32_t>(v), 0.0, signs);
                const Vec3& p = points_[v];
                for (std::size_t i = 0; i < n_labels_[v]; ++i) {
                    const double g = norm(outward(labels_[v][i], p));
                    if (g > 0.0)
                        rounding_[v] =
                            std::max(rounding_[v], 4.0 * forms_[labels_[v][i] >> 1].slack() / g);
                }
            }
        });
        for (std::size_t f = 0; f < m_.mesh.n_faces(); ++f) {
            const std::array<double, 2> e = own_distance(static_cast<std::int32_t>(f));
            for (const int side : {0, 1})
                for (const std::int32_t v : face(f, side))
                    offset_[v][side] = std::max(offset_[v][side], 1.02 * e[side] + rounding_[v]);
        }
        for (std::size_t v = 0; v < n; ++v)
            for (double& a : offset_[v]) a = std::min(a, kUpTo * tolerance_ / norm(direction_[v]));
        if (least_ > 0.0) keep_apart();
        open_.assign(m_.mesh.n_faces(), 3);
    }

    // Thick, but flat beside the faces.
    void keep_apart()
    {
        std::vector<double> shortest(points_.size(), kInfinity);
        for (const int side : {0, 1})
            for (const Triangle& t : faces(side))
                for (std::size_t i = 0; i < 3; ++i) {
                    const std::int32_t a = t[i], b = t[(i + 1) % 3];
                    const double length = distance(points_[a], points_[b]);
                    for (const std::int32_t v : {a, b}) shortest[v] = std::min(shortest[v], length);
                }
        for (std::size_t v = 0; v < offset_.size(); ++v)
            for (double& a : offset_[v])
                a = std::max(a, std::min(least_, kFlatness * shortest[v]) / norm(direction_[v]));
        // Beside a curve the other surface passes through the prisms too, and is to grow there.
        parallel_for(offset_.size(), 256, [&](std::size_t begin, std::size_t end) {
            std::vector<Sign> signs(forms_.size(), Sign{0});
            for (std::size_t v = begin; v < end; ++v) {
                const double reach = kBeside * std::max(offset_[v][0], offset_[v][1]);
                const double before = norm(direction_[v]);
                direction_[v] = choose_direction(static_cast<std::int32_t>(v), reach, signs);
                const double limit = tolerance_ / norm(direction_[v]);
                for (double& a : offset_[v])
                    a = std::min(limit, std::max(a, a * before / norm(direction_[v])));
            }
        });
    }

    // How far the face's own surface may lie outside and inside of the face, about.
    std::array<double, 2> own_distance(std::int32_t f) const
    {
        const std::int32_t label = m_.surface_of_face[f];
        const std::array<Vec3, 3> p = face_corners(f);
        const Interval r = forms_[label >> 1].range(p);
        double g = kInfinity;
        for (const Vec3& x : p) g = std::min(g, norm(outward(label, x)));
        if (!(g > 0.0)) return {tolerance_, tolerance_};
        const double below = std::min(std::max(0.0, -r.lo) / g, tolerance_);
        const double above = std::min(std::max(0.0, r.hi) / g, tolerance_);
        return (label & 1) != 0 ? std::array{above, below} : std::array{below, above};
    }

    std::array<Vec3, 3> face_corners(std::int32_t f) const
    {
        const Triangle& t = m_.mesh.faces[f];
        return {m_.mesh.vertices[t[0]], m_.mesh.vertices[t[1]], m_.mesh.vertices[t[2]]};
    }

    // The shortest way in which all surfaces that meet at the vertex grow at their full rate.
    // Surfaces that pass within `reach` without meeting count less the farther they are, so that
    // directions of neighbouring vertices are alike.
    Vec3 choose_direction(std::int32_t v, double reach, std::vector<Sign>& signs) const
    {
        const Vec3& p = points_[v];
        std::vector<Vec3> normals;
        std::vector<double> demands;
        for (std::size_t i = 0; i < n_labels_[v]; ++i) {
            normals.push_back(normalized(outward(labels_[v][i], p)));
            demands.push_back(1.0);
        }
        const std::size_t n_own = normals.size();
        if (reach > 0.0) {
            const SignFormula& near = groups_[group_of_vertex_[v]].formula;
            Box3 box;
            box.add(p);
            find_signs(near, forms_, box.inflated(reach), signs);
            const SignFormula here = near.simplified(signs);
            for (std::size_t i = 0; i < here.surfaces().size(); ++i) {
                const std::int32_t s = here.surfaces()[i];
                const Vec3 g = forms_[s].gradient(p);
                const double size = norm(g);
                if (!(size > 0.0)) continue;
                const double far = std::fabs(forms_[s].value(p)) / size / reach;
                const double demand = std::min(1.0, 3.0 - 4.0 * far);
                if (demand <= -1.0) continue;
                for (const bool turned : {false, true}) {
                    if (!(turned ? here.uses()[i].negated : here.uses()[i].plain)) continue;
                    normals.push_back((turned ? -1.0 : 1.0) / size * g);
                    demands.push_back(demand);
                }
            }
        }
        if (n_own == 1 && normals.size() == 1) return normals[0];
        auto d = shortest_direction(normals, demands);
        if (!d && normals.size() > n_own)
            d = shortest_direction(std::span(normals).first(n_own),
                                   std::span(demands).first(n_own));
        if (d) return *d;
        Vec3 mean;
        for (std::size_t i = 0; i < n_own; ++i) mean += normals[i];
        return normalized(mean);
    }

    Vec3 corner(std::int32_t v, int side) const
    {
        const double step = side == 0 ? offset_[v][0] : -offset_[v][1];
        return points_[v] + step * direction_[v];
    }

    void check_faces(const std::vector<char>& pending)
    {
        parallel_for(groups_.size(), 8, [&](std::size_t begin, std::size_t end) {
            std::vector<Sign> signs(forms_.size(), Sign{0});
            for (std::size_t g = begin; g < end; ++g)
                for (const std::int32_t f : groups_[g].faces) {
                    if (pending[f] == 0) continue;
                    open_[f] = 0;
                    for (const int side : {0, 1}) {
                        const Triangle& t = face(f, side);
                        const std::array<Vec3, 3> p{corner(t[0], side), corner(t[1], side),
                                                    corner(t[2], side)};
                        find_signs(groups_[g].formula, forms_, p, signs);
                        if (groups_[g].formula.sign_by_cases(signs) != (side == 0 ? 1 : -1))
                            open_[f] = static_cast<char>(open_[f] | 1 << side);
                    }
                }
        });
    }

    bool widen(std::int32_t v, int sides)
    {
        // Corners of small faces stop half way: a neighbour can still vouch for these.
        const double limit = (sides & kLarge) != 0 ? kUpTo * tolerance_ : 0.5 * tolerance_;
        bool changed = false;
        for (const std::size_t side : {0u, 1u}) {
            if ((sides >> side & 1) == 0) continue;
            double& a = offset_[v][side];
            if (a * norm(direction_[v]) >= limit) continue;
            a = kGrowth * a + rounding_[v];
            changed = true;
        }
        if (!changed) return false;
        std::vector<Sign> signs(forms_.size(), Sign{0});
        direction_[v] = choose_direction(v, 4.0 * std::max(offset_[v][0], offset_[v][1]), signs);
        const double length = norm(direction_[v]);
        for (double& a : offset_[v]) a = std::min(a, limit / length);
        return true;
    }

    const SurfaceMesh& m_;
    const std::vector<SurfaceForm>& forms_;
    double tolerance_;
    double least_;
    std::vector<Vec3> points_;           // the vertices of M+ and M-, before they move
    std::vector<Triangle> outer_faces_;  // of M+, if others than M- and the mesh have
    std::vector<Group> groups_;
    std::vector<std::int32_t> group_of_vertex_;
    std::vector<std::array<std::int32_t, 6>> labels_;
    std::vector<std::uint8_t> n_labels_;
    std::vector<Vec3> direction_;
    std::vector<std::array<double, 2>> offset_;  // outward, inward; in units of the direction
    std::vector<double> rounding_;
    std::vector<char> open_;  // bit 0: M+ not shown outside, bit 1: M- not shown inside
};

// The way from surface to mesh.
class Search {
public:
    /// `open`: boxes of those faces of the outer and inner mesh that no way may come near.
    /// `strict`: being near the mesh is not enough.
    Search(const IndexedMesh& mesh, const IndexedMesh& outer, const IndexedMesh& inner,
           std::span<const Box3> open, const std::vector<SurfaceForm>& forms, double tolerance,
           bool strict)
        : mesh_(mesh),
          outer_(outer),
          inner_(inner),
          open_(open),
          forms_(forms),
          tolerance_(tolerance),
          strict_(strict)
    {
    }

    void run(const Box3& cube, const SignFormula& formula, Certificate& c)
    {
        enough_ = std::min(tolerance_, std::max(c.bound, 0.25 * tolerance_));
        std::vector<Item> level{{cube, formula}};
        while (!level.empty() && c.n_failed <= kMaxListed &&
               c.n_boxes <= (strict_ ? kMaxBoxesStrict : kMaxBoxes)) {
            c.n_boxes += static_cast<std::int64_t>(level.size());
            std::vector<Outcome> outcomes(level.size());
            parallel_for(level.size(), 16, [&](std::size_t begin, std::size_t end) {
                std::vector<Sign> signs(forms_.size(), Sign{0});
                for (std::size_t i = begin; i < end; ++i) outcomes[i] = look(level[i], signs);
            });
            std::vector<Item> next;
            for (std::size_t i = 0; i < level.size(); ++i) {
                nearness_ = std::max(nearness_, outcomes[i].nearness);
                if (outcomes[i].kind == Outcome::Open) divide(level[i], next);
                if (outcomes[i].kind != Outcome::Failed) continue;
                ++c.n_failed;
                c.failed.push_back(level[i].box);
            }
            level.swap(next);
        }
        if (!level.empty()) {
            c.n_failed += static_cast<std::int64_t>(level.size());
            for (std::size_t i = 0; i < level.size() && i < 64; ++i)
                c.failed.push_back(level[i].box);
        }
        c.bound = std::max(c.bound, nearness_);
    }

private:
    struct Item {
        Box3 box;
        SignFormula formula;  // good for `wide(box)`
    };
    // The box with the surroundings in which ways are sought.
    Box3 wide(const Box3& box) const
    {
        return box.inflated((strict_ ? 8.0 : 2.0) * (box.max[0] - box.min[0]));
    }

    struct Outcome {
        enum Kind { Done, Open, Failed } kind = Done;
        double nearness = 0.0;
    };

    static void divide(const Item& item, std::vector<Item>& next)
    {
        const Vec3 c = item.box.center();
        for (int k = 0; k < 8; ++k) {
            Box3 part = item.box;
            for (std::size_t a = 0; a < 3; ++a)
                ((k >> a & 1) != 0 ? part.min[a] : part.max[a]) = c[a];
            next.push_back({part, item.formula});
        }
    }

    Outcome look(Item& item, std::vector<Sign>& signs) const
    {
        find_signs(item.formula, forms_, item.box, signs);
        const SignFormula here = item.formula.simplified(signs);
        if (here.constant() != 0) return {};
        find_signs(item.formula, forms_, wide(item.box), signs);
        item.formula = item.formula.simplified(signs);
        const double radius = 0.5 * item.box.diagonal();
        const Vec3 c = item.box.center();
        const Ways ways = find_ways(item, here, signs);
        // If the ends have the wrong sign, no point of the box is on the surface.
        if (ways.found && (ways.none || (outer_.winding_number(ways.inside) == 1 &&
                                         inner_.winding_number(ways.outside) == 0)))
            return {};
        if (strict_ && radius <= kLargestShare * tolerance_) {
            if (between(c, radius)) return {};
            if (radius <= kSmallestShare * tolerance_) return {Outcome::Failed};
        } else if (!strict_ && radius <= 0.5 * tolerance_) {
            // Nearness counts towards the bound, so it should not be had too cheaply.
            const double d = (mesh_.nearest(c).distance + radius) * (1.0 + 1e-12);
            if (d <= (radius <= kSmallBox * tolerance_ ? tolerance_ : enough_))
                return {Outcome::Done, d};
            if (radius <= kSmallestBox * tolerance_) return {Outcome::Failed};
        }
        return {ways.found && far_from_mesh(c, radius) ? Outcome::Failed : Outcome::Open};
    }

    // All of the ball lies between M- and M+: it meets neither, and its centre does.
    bool between(const Vec3& c, double radius) const
    {
        const double far = radius * (1.0 + 1e-9);
        return outer_.nearest(c, far).face < 0 && inner_.nearest(c, far).face < 0 &&
               outer_.winding_number(c) == 1 && inner_.winding_number(c) == 0;
    }

    bool far_from_mesh(const Vec3& c, double radius) const
    {
        const double far = radius + tolerance_;
        return mesh_.nearest(c, far).face < 0;
    }

    struct Ways {
        bool found = false, none = false;
        Vec3 inside, outside;
    };

    struct Directed {
        std::int32_t surface;
        double sign;
    };
    static bool directed(const SignFormula& f, std::vector<Directed>& out)
    {
        out.clear();
        for (std::size_t i = 0; i < f.surfaces().size(); ++i) {
            const SignFormula::Use use = f.uses()[i];
            if (use.plain == use.negated) return false;
            out.push_back({f.surfaces()[i], use.plain ? 1.0 : -1.0});
        }
        return true;
    }

    // Points c - Hd and c + Hd that all points of the box reach on ways along which every surface
    // that decides there falls, or grows.
    Ways find_ways(const Item& item, const SignFormula& here, std::vector<Sign>& signs) const
    {
        std::vector<Directed> near;
        if (here.surfaces().size() > 12 || !directed(here, near)) return {};
        const Vec3 c = item.box.center(), half = 0.5 * item.box.size();
        const Box3 steps{-half, half};
        for (int attempt = 0; attempt < 3; ++attempt) {
            std::vector<Vec3> normals;
            for (const Directed& s : near)
                normals.push_back(s.sign * normalized(forms_[s.surface].gradient(c)));
            const std::vector<double> ones(normals.size(), 1.0);
            const auto shortest = shortest_direction(normals, ones);
            if (!shortest || norm(*shortest) > (strict_ ? 8.0 : 2.0)) return {};
            const Vec3 d = normalized(*shortest);
            double height = 0.0;
            for (const Vec3& n : normals) {
                const double across = std::fabs(n[0]) * half[0] + std::fabs(n[1]) * half[1] +
                                      std::fabs(n[2]) * half[2];
                height = std::max(height, across / dot(n, d));
            }
            height *= 1.3;
            const Vec3 up = height * d;
            Box3 hull = item.box;
            hull.add(c + up);
            hull.add(c - up);
            if (!wide(item.box).contains(hull) || meets_open_face(hull)) return {};
            find_signs(item.formula, forms_, hull, signs);
            const SignFormula around = item.formula.simplified(signs);
            std::vector<Directed> all;
            if (around.surfaces().size() > 12 || !directed(around, all)) return {};
            if (all.size() == near.size()) {
                if (!grows(all, hull, up, steps)) return {};
                return ends(around, c - up, c + up, signs);
            }
            near.swap(all);
        }
        return {};
    }

    bool meets_open_face(const Box3& hull) const
    {
        bool any = false;
        open_.visit_overlapping(hull, [&](std::int32_t) { any = true; });
        return any;
    }

    // Every surface grows along up - x for all x of `steps`, everywhere in the hull.
    bool grows(const std::vector<Directed>& surfaces, const Box3& hull, const Vec3& up,
               const Box3& steps) const
    {
        const Box3 moves{steps.min + up, steps.max + up};
        const IntervalVec3 m = to_intervals(moves);
        for (const Directed& s : surfaces) {
            const IntervalVec3 g = forms_[s.surface].gradient_range(hull);
            const Interval slope = (g[0] * m[0] + g[1] * m[1] + g[2] * m[2]) * s.sign;
            if (!(slope.lo > 0.0)) return false;
        }
        return true;
    }

    Ways ends(const SignFormula& f, const Vec3& inside, const Vec3& outside,
              std::vector<Sign>& signs) const
    {
        Ways ways{true, false, inside, outside};
        const auto sign_at = [&](const Vec3& p) {
            for (const std::int32_t s : f.surfaces()) signs[s] = forms_[s].sign(p);
            return f.sign_by_cases(signs);
        };
        ways.none = sign_at(inside) > 0 || sign_at(outside) < 0;
        return ways;
    }

    MeshTree mesh_, outer_, inner_;
    BoxTree open_;
    const std::vector<SurfaceForm>& forms_;
    double tolerance_;
    bool strict_;
    double enough_ = 0.0;
    double nearness_ = 0.0;
};

}  // namespace

std::vector<std::pair<std::string, double>> Certificate::parts() const
{
    std::vector<std::pair<std::string, double>> named{
        {"faces", faces}, {"edges and corners", creases}, {"rounding", rounding}};
    std::stable_sort(named.begin(), named.end(),
                     [](const auto& x, const auto& y) { return x.second > y.second; });
    return named;
}

Certificate certify(const SurfaceMesh& mesh, const SignFormula& formula,
                    const std::vector<SurfaceForm>& forms, const Box3& cube, double tolerance,
                    Sandwich* sandwich)
{
    Certificate c;
    Shell shell(mesh, formula, forms, tolerance, sandwich ? sandwich->thickness * tolerance : 0.0);
    shell.grow();
    shell.report(c, sandwich != nullptr);
    if (c.n_failed > 0) return c;
    IndexedMesh outer = shell.moved(0), inner = shell.moved(1);
    Search search(mesh.mesh, outer, inner, shell.open_boxes(), forms, tolerance,
                  sandwich != nullptr);
    search.run(cube, formula, c);
    if (sandwich) {
        sandwich->outer = std::move(outer);
        sandwich->inner = std::move(inner);
    }
    return c;
}

}  // namespace genus
