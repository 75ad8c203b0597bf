#include "genus/model/certificate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "genus/base/halves.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/model/fans.h"
#include "genus/model/form_signs.h"
#include "genus/model/surface_search.h"

namespace genus {

namespace {

constexpr std::size_t kGroupFaces = 24;
constexpr int kMaxRounds = 24;
constexpr double kGrowth = 1.25;
constexpr double kUpTo = 1.0 - 0x1p-50;  // of the tolerance, rounding allowed for
constexpr double kSmallFace = 0.25;      // diagonal, of the tolerance
constexpr int kLarge = 4;                // beside the bits of the two sides
constexpr double kBeside = 5.0;          // reach of a direction, of the thickness
constexpr double kFlatness = 0.1;        // of a sandwich, of the shortest edge
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Faces near each other with the formula cut down to the surfaces that decide near them.
struct Group {
    std::vector<std::int32_t> faces;
    SignFormula formula;
};

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
            if (static_cast<std::int64_t>(c.failed.size()) < Certificate::kMostListed)
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
    find_surface_near(
        {mesh.mesh, outer, inner, shell.open_boxes(), forms, tolerance, sandwich != nullptr}, cube,
        formula, c);
    if (sandwich) {
        sandwich->outer = std::move(outer);
        sandwich->inner = std::move(inner);
    }
    return c;
}

}  // namespace genus
