#include "genus/boolean/mesh_boolean.h"

#include <algorithm>
#include <limits>
#include <string>

#include "genus/base/box.h"
#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/boolean/close_coordinates.h"
#include "genus/boolean/closed_operand.h"
#include "genus/boolean/groups.h"
#include "genus/boolean/operand.h"
#include "genus/mesh/disjoint_sets.h"

namespace genus {

namespace {

using exact::ClosedOperand;
using exact::Frame;
using exact::Soup;
using Index = std::int32_t;

constexpr int kCoarserBits = 4;
constexpr std::size_t kMostGrids = 16;  // on which it is remembered that an operand is clean

std::string place_text(const Vec3& p)
{
    return "(" + to_text(p[0]) + ", " + to_text(p[1]) + ", " + to_text(p[2]) + ")";
}

using Operands = std::span<const BooleanOperand>;

// All of one call: operands made ready, their components and the clusters of these.
class Call {
public:
    Call(Operands operands, const BooleanFormula& formula, const MeshBooleanOptions& options)
        : operands_(operands), formula_(formula), options_(options)
    {
    }

    MeshBooleanResult run()
    {
        close_operands();
        find_clusters();
        for (Index c = 0; c < n_clusters_; ++c) {
            current_progress().check();
            solve_cluster(c);
        }
        result_.clean = result_.clean && n_clusters_ == 1;
        return std::move(result_);
    }

private:
    const IndexedMesh& mesh_of(std::size_t i) const { return operands_[i].mesh(); }

    void close_operands()
    {
        ready_.resize(operands_.size());
        std::vector<char> was_known(operands_.size(), 0);
        parallel_for(operands_.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                BooleanOperand::Known& known = operands_[i].known();
                const std::lock_guard lock(known.mutex);
                was_known[i] = known.closed != nullptr;
                if (!known.closed)
                    known.closed = std::make_shared<const ClosedOperand>(
                        exact::close_operand(*known.mesh, static_cast<Index>(i)));
                ready_[i] = known.closed;
            }
        });
        result_.report.n_known = std::count(was_known.begin(), was_known.end(), 1);
    }

    // With all that a few roundings might have moved into the box.
    static Box3 nearby(const Box3& box)
    {
        double largest = 0.0;
        for (int k = 0; k < 3; ++k)
            largest = std::max({largest, std::abs(box.min[k]), std::abs(box.max[k])});
        return box.inflated(exact::kCloseUnits * std::numeric_limits<double>::epsilon() * largest);
    }

    void find_clusters()
    {
        std::vector<Index> start{0};
        std::vector<Box3> boxes;
        for (const auto& operand : ready_) {
            boxes.insert(boxes.end(), operand->boxes.begin(), operand->boxes.end());
            start.push_back(static_cast<Index>(boxes.size()));
        }
        DisjointSets sets(boxes.size());
        std::vector<exact::FloatBox> rough;
        for (const Box3& b : boxes)
            rough.push_back(exact::box_of(nearby(b).min, nearby(b).max, nearby(b).min));
        const exact::BoxTree tree(std::move(rough), {});
        std::vector<std::vector<std::pair<Index, Index>>> touching;
        tree.visit_pairs([&](std::size_t parts) { touching.resize(parts); },
                         [&](Index a, Index b, std::size_t part) {
                             if (overlap(nearby(boxes[a]), nearby(boxes[b])))
                                 touching[part].push_back({a, b});
                         });
        for (const auto& part : touching)
            for (const auto& [a, b] : part) sets.unite(a, b);

        std::vector<Index> number(boxes.size(), -1);
        for (Index c = 0; c < static_cast<Index>(boxes.size()); ++c) {
            Index& known = number[sets.find(c)];
            if (known < 0) {
                known = n_clusters_++;
                cluster_box_.emplace_back();
            }
            number[c] = known;
            cluster_box_[known].add(boxes[c]);
        }
        list_faces(start, number);
        result_.report.n_components = start.back();
        result_.report.n_clusters = n_clusters_;
    }

    // By cluster, from the number of the first component of each operand and the clusters of all.
    void list_faces(const std::vector<Index>& start, const std::vector<Index>& cluster)
    {
        cluster_faces_.resize(n_clusters_);
        if (n_clusters_ < 2) return;  // all of them, see for_each_face
        for (std::size_t i = 0; i < ready_.size(); ++i)
            for (std::size_t f = 0; f < ready_[i]->faces.size(); ++f) {
                const Index component = ready_[i]->component_of(static_cast<Index>(f));
                cluster_faces_[cluster[start[i] + component]].push_back(
                    {static_cast<Index>(i), static_cast<Index>(f)});
            }
    }

    // Calls use(operand, face) for those of a cluster.
    template <class Use>
    void for_each_face(Index c, const Use& use) const
    {
        if (n_clusters_ > 1) {
            for (const auto& [i, f] : cluster_faces_[c]) use(i, f);
            return;
        }
        for (std::size_t i = 0; i < ready_.size(); ++i)
            for (std::size_t f = 0; f < ready_[i]->faces.size(); ++f)
                use(static_cast<Index>(i), static_cast<Index>(f));
    }

    void solve_cluster(Index c)
    {
        const Frame frame(cluster_box_[c]);
        Vec3 place;
        for (int bits = 0; bits == 0 || frame.coarseness(bits) <= options_.most_snap;
             bits += kCoarserBits) {
            const double largest_snap = result_.report.largest_snap;
            const Soup soup = make_soup(c, frame, bits);
            const std::int64_t n_cells = result_.report.n_cells;
            auto solved =
                exact::solve_in_groups(soup, frame, formula_, static_cast<Index>(operands_.size()),
                                       options_, result_.report, place);
            if (!solved) continue;
            note_clean(soup, *solved, frame);
            const std::size_t n_faces = solved->faces.size();
            result_.clean =
                options_.operands_may_cross_themselves && solved->saw_all && !solved->parts_touch;
            append(std::move(*solved), frame);
            if (n_cells == result_.report.n_cells && bits == 0 && is_one_part(c)) {
                restore(n_faces);
                result_.clean = false;
                result_.report.largest_snap = largest_snap;
            }
            cluster_faces_[c] = {};
            return;
        }
        throw Error(
            "mesh_boolean: the result cannot be written in doubles without crossing itself "
            "near " +
            place_text(place));
    }

    bool is_one_part(Index c) const
    {
        std::pair<Index, Index> first{-1, -1};
        bool is_one = true;
        for_each_face(c, [&](Index i, Index f) {
            const std::pair<Index, Index> part{i, ready_[i]->component_of(f)};
            if (first.first < 0) first = part;
            is_one = is_one && part == first;
        });
        return is_one;
    }

    // Gives the last `n` faces, which nothing touched, the very coordinates of their source.
    void restore(std::size_t n)
    {
        const auto& faces = result_.mesh.faces;
        for (std::size_t f = faces.size() - n; f < faces.size(); ++f) {
            const IndexedMesh& from = mesh_of(result_.operand[f]);
            const Triangle& t = from.faces[result_.source_face[f]];
            const Vec3* p[3];
            for (int i = 0; i < 3; ++i) p[i] = &from.vertices[t[i]];
            // The face may have been turned over, its first corner stayed.
            const auto off = [&](int i, int j) {
                return distance(result_.mesh.vertices[faces[f][i]], *p[j]);
            };
            if (off(1, 1) + off(2, 2) > off(1, 2) + off(2, 1)) std::swap(p[1], p[2]);
            for (int i = 0; i < 3; ++i) result_.mesh.vertices[faces[f][i]] = *p[i];
        }
    }

    Soup make_soup(Index c, const Frame& frame, int bits)
    {
        Soup soup;
        soup.crosses_itself.assign(operands_.size(), options_.operands_may_cross_themselves);
        // What happens to corners beyond rounding to the grid.
        std::vector<char> moved(operands_.size(), bits > 0);
        rounded_.assign(operands_.size(), 0);
        add_faces(c, soup);
        const double largest = add_points(c, frame, bits, soup, moved);
        drop_flat(soup, moved);
        std::vector<std::size_t> n_faces(operands_.size(), 0);
        for (const Index i : soup.operand) ++n_faces[i];
        for (std::size_t i = 0; i < operands_.size(); ++i) {
            whole_[i] = !moved[i] && n_faces[i] == ready_[i]->faces.size() && n_faces[i] > 0;
            if (moved[i])
                soup.crosses_itself[i] = 1;
            else if (whole_[i] && soup.crosses_itself[i] && is_known_clean(i, frame)) {
                soup.crosses_itself[i] = 0;
                ++result_.report.n_known_clean;
            }
        }
        auto& report = result_.report;
        report.grid_step = std::max(report.grid_step, frame.step());
        report.largest_snap = std::max(report.largest_snap, largest * frame.step());
        return soup;
    }

    // The faces of a cluster with numbers for their corners, by operand and first use.
    void add_faces(Index c, Soup& soup)
    {
        if (vertex_.empty()) {
            for (std::size_t i = 0; i < operands_.size(); ++i) {
                vertex_.emplace_back(mesh_of(i).vertices.size(), -1);
                if (n_clusters_ > 1) place_.emplace_back(ready_[i]->faces.size(), -1);
            }
        } else {
            for_each_face(c, [&](Index i, Index f) {
                for (const Index v : ready_[i]->faces[f]) vertex_[i][v] = -1;
            });
        }
        std::size_t n = 0;
        for (const auto& operand : ready_) n += operand->faces.size();
        if (n_clusters_ > 1) n = cluster_faces_[c].size();
        soup.faces.reserve(n);
        soup.operand.reserve(n);
        soup.given.reserve(n);
        soup.twin.reserve(3 * n);
        n_points_ = 0;
        for_each_face(c, [&](Index i, Index f) {
            Triangle t = ready_[i]->faces[f];
            for (Index& v : t) {
                Index& known = vertex_[i][v];
                if (known < 0) known = n_points_++;
                v = known;
            }
            if (n_clusters_ > 1) place_[i][f] = static_cast<Index>(soup.faces.size());
            soup.faces.push_back(t);
            soup.operand.push_back(i);
            soup.given.push_back({i, ready_[i]->source.empty() ? f : ready_[i]->source[f]});
        });
        add_twins(c, soup);
    }

    void add_twins(Index c, Soup& soup) const
    {
        if (n_clusters_ > 1) {
            for_each_face(c, [&](Index i, Index f) {
                for (int k = 0; k < 3; ++k) {
                    const Index h = ready_[i]->twin[3 * f + k];
                    soup.twin.push_back(h < 0 ? -1 : 3 * place_[i][h / 3] + h % 3);
                }
            });
            return;
        }
        for (const auto& operand : ready_) {
            const auto first = static_cast<Index>(soup.twin.size());
            for (const Index h : operand->twin) soup.twin.push_back(h < 0 ? -1 : first + h);
        }
    }

    // Returns the largest distance in steps that a coordinate is moved by.
    double add_points(Index c, const Frame& frame, int bits, Soup& soup, std::vector<char>& moved)
    {
        double largest = 0.0;
        std::vector<Index> owner(n_points_);  // of each point, an operand
        soup.points.resize(n_points_);
        Index next = 0;
        for_each_face(c, [&](Index i, Index f) {
            for (const Index v : ready_[i]->faces[f]) {
                if (vertex_[i][v] != next) continue;
                double off = 0.0;
                Vec3 p = frame.to_grid(mesh_of(i).vertices[v], off);
                if (bits > 0) {
                    const Vec3 q = frame.coarsened(p, bits);
                    for (int k = 0; k < 3; ++k) off = std::max(off, std::abs(q[k] - p[k]));
                    p = q;
                }
                soup.points[next] = p;
                owner[next++] = i;
                if (off > 0.0) rounded_[i] = 1;
                largest = std::max(largest, off);
            }
        });
        const auto merged = exact::merge_close_coordinates(soup.points, soup.faces,
                                                           frame.close(options_.most_snap));
        for (std::size_t n = 0; n < merged.size(); ++n) {
            if (merged[n] > 0.0) moved[owner[n]] = 1;
            largest = std::max(largest, merged[n]);
        }
        return largest;
    }

    // Leaves out the faces that have no area on the grid.
    static void drop_flat(Soup& soup, std::vector<char>& moved)
    {
        const std::size_t n = soup.faces.size();
        const auto flat = [&](std::size_t f) {
            const Triangle& t = soup.faces[f];
            return exact::is_flat(soup.points[t[0]], soup.points[t[1]], soup.points[t[2]]);
        };
        std::size_t first = 0;
        while (first < n && !flat(first)) ++first;
        if (first == n) return;
        std::vector<Index> place(n, -1);
        std::size_t n_kept = 0;
        for (std::size_t f = 0; f < n; ++f) {
            if (f >= first && flat(f))
                moved[soup.operand[f]] = 1;
            else
                place[f] = static_cast<Index>(n_kept++);
        }
        for (std::size_t f = 0; f < n; ++f) {
            if (place[f] < 0) continue;
            const auto to = static_cast<std::size_t>(place[f]);
            soup.faces[to] = soup.faces[f];
            soup.operand[to] = soup.operand[f];
            soup.given[to] = soup.given[f];
            for (std::size_t k = 0; k < 3; ++k) {
                const Index h = soup.twin[3 * f + k];
                const Index at = h < 0 ? -1 : place[h / 3];
                soup.twin[3 * to + k] = at < 0 ? -1 : 3 * at + h % 3;
            }
        }
        soup.faces.resize(n_kept);
        soup.operand.resize(n_kept);
        soup.given.resize(n_kept);
        soup.twin.resize(3 * n_kept);
    }

    // Was an operand, all of it and moved by no more than rounding to the grid, seen not to touch
    // itself?
    bool is_known_clean(std::size_t i, const Frame& frame) const
    {
        BooleanOperand::Known& known = operands_[i].known();
        const std::lock_guard lock(known.mutex);
        if (!rounded_[i]) return known.clean;
        return std::any_of(known.clean_on.begin(), known.clean_on.end(),
                           [&](const Frame& f) { return f.same_grid(frame); });
    }

    void note_clean(const Soup& soup, const exact::Solved& solved, const Frame& frame)
    {
        if (!solved.saw_all) return;
        std::vector<char> clean = whole_;
        for (const Index i : solved.touch_themselves) clean[i] = 0;
        for (std::size_t i = 0; i < operands_.size(); ++i) {
            if (!clean[i] || !soup.crosses_itself[i]) continue;
            BooleanOperand::Known& known = operands_[i].known();
            const std::lock_guard lock(known.mutex);
            if (!rounded_[i])
                known.clean = true;
            else if (known.clean_on.size() < kMostGrids)
                known.clean_on.push_back(frame);
        }
    }

    void append(exact::Solved solved, const Frame& frame)
    {
        IndexedMesh& mesh = result_.mesh;
        const auto base = static_cast<Index>(mesh.vertices.size());
        if (n_clusters_ == 1) {
            result_.operand.reserve(solved.faces.size());
            result_.source_face.reserve(solved.faces.size());
        }
        for (Vec3& p : solved.points) p = frame.from_grid(p);
        for (Triangle& t : solved.faces)
            for (Index& v : t) v += base;
        const auto move_to_end = [](auto& to, auto& from) {
            if (to.empty())
                to = std::move(from);
            else
                to.insert(to.end(), from.begin(), from.end());
        };
        move_to_end(mesh.vertices, solved.points);
        move_to_end(mesh.faces, solved.faces);
        for (const auto& [operand, face] : solved.given) {
            result_.operand.push_back(operand);
            result_.source_face.push_back(face);
        }
    }

    Operands operands_;
    const BooleanFormula& formula_;
    const MeshBooleanOptions& options_;
    std::vector<std::shared_ptr<const ClosedOperand>> ready_;
    Index n_clusters_ = 0;
    std::vector<Box3> cluster_box_;
    std::vector<std::vector<std::pair<Index, Index>>> cluster_faces_;  // of several clusters
    // By operand: moved by rounding to the grid; and all of it in this cluster, moved by no more.
    std::vector<char> rounded_;
    std::vector<char> whole_ = std::vector<char>(operands_.size(), 0);
    std::vector<std::vector<Index>> place_;   // by operand and face: number in its soup, of several
    std::vector<std::vector<Index>> vertex_;  // by operand and vertex: number in its soup
    Index n_points_ = 0;                      // of the soup
    MeshBooleanResult result_;
};

}  // namespace

BooleanOperand::BooleanOperand(std::shared_ptr<const IndexedMesh> mesh, bool clean)
    : known_(std::make_shared<Known>())
{
    known_->mesh = std::move(mesh);
    known_->clean = clean;
}

const IndexedMesh& BooleanOperand::mesh() const
{
    return *known_->mesh;
}

MeshBooleanResult mesh_boolean(std::span<const IndexedMesh> operands, const BooleanFormula& formula,
                               const MeshBooleanOptions& options)
{
    std::vector<BooleanOperand> known;
    // The caller keeps the meshes.
    for (const IndexedMesh& mesh : operands)
        known.emplace_back(std::shared_ptr<const IndexedMesh>(std::shared_ptr<void>(), &mesh));
    return mesh_boolean(known, formula, options);
}

MeshBooleanResult mesh_boolean(std::span<const BooleanOperand> operands,
                               const BooleanFormula& formula, const MeshBooleanOptions& options)
{
    formula.check(static_cast<Index>(operands.size()));
    return Call(operands, formula, options).run();
}

IndexedMesh unite(std::span<const IndexedMesh> operands)
{
    return mesh_boolean(operands, BooleanFormula::union_of(static_cast<Index>(operands.size())))
        .mesh;
}

IndexedMesh intersect(std::span<const IndexedMesh> operands)
{
    return mesh_boolean(operands,
                        BooleanFormula::intersection_of(static_cast<Index>(operands.size())))
        .mesh;
}

IndexedMesh subtract(std::span<const IndexedMesh> operands)
{
    return mesh_boolean(operands,
                        BooleanFormula::difference_of(static_cast<Index>(operands.size())))
        .mesh;
}

}  // namespace genus
