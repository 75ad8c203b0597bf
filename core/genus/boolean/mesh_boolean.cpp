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
        for (const auto& operand : ready_) start.push_back(start.back() + operand->n_components);
        std::vector<Box3> boxes(start.back());
        for (std::size_t i = 0; i < ready_.size(); ++i)
            for (std::size_t f = 0; f < ready_[i]->faces.size(); ++f)
                for (const Index v : ready_[i]->faces[f])
                    boxes[start[i] + ready_[i]->component[f]].add(mesh_of(i).vertices[v]);
        DisjointSets sets(start.back());
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

        std::vector<Index> number(start.back(), -1);
        for (Index c = 0; c < start.back(); ++c) {
            Index& known = number[sets.find(c)];
            if (known < 0) {
                known = n_clusters_++;
                cluster_box_.emplace_back();
            }
            number[c] = known;
            cluster_box_[known].add(boxes[c]);
        }
        cluster_faces_.resize(n_clusters_);
        if (n_clusters_ == 1) {
            std::size_t n_faces = 0;
            for (const auto& operand : ready_) n_faces += operand->faces.size();
            cluster_faces_[0].reserve(n_faces);
        }
        for (std::size_t i = 0; i < ready_.size(); ++i)
            for (std::size_t f = 0; f < ready_[i]->faces.size(); ++f)
                cluster_faces_[number[start[i] + ready_[i]->component[f]]].push_back(
                    {static_cast<Index>(i), static_cast<Index>(f)});
        result_.report.n_components = start.back();
        result_.report.n_clusters = n_clusters_;
    }

    void solve_cluster(Index c)
    {
        const Frame frame(cluster_box_[c]);
        Vec3 place;
        for (int bits = 0; bits == 0 || frame.coarseness(bits) <= options_.most_snap;
             bits += kCoarserBits) {
            const double largest_snap = result_.report.largest_snap;
            const Soup soup = make_soup(cluster_faces_[c], frame, bits);
            const std::int64_t n_cells = result_.report.n_cells;
            const auto solved =
                exact::solve_in_groups(soup, frame, formula_, static_cast<Index>(operands_.size()),
                                       options_, result_.report, place);
            if (!solved) continue;
            append(*solved, frame);
            note_clean(soup, *solved, frame);
            result_.clean =
                options_.operands_may_cross_themselves && solved->saw_all && !solved->parts_touch;
            if (n_cells == result_.report.n_cells && bits == 0 && is_one_part(c)) {
                restore(solved->faces.size());
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
        const auto part = [&](const std::pair<Index, Index>& at) {
            return std::pair(at.first, ready_[at.first]->component[at.second]);
        };
        const auto& faces = cluster_faces_[c];
        return std::all_of(faces.begin(), faces.end(),
                           [&](const auto& at) { return part(at) == part(faces[0]); });
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

    Soup make_soup(const std::vector<std::pair<Index, Index>>& faces, const Frame& frame, int bits)
    {
        Soup soup;
        soup.crosses_itself.assign(operands_.size(), options_.operands_may_cross_themselves);
        forget_numbers(faces);
        // What happens to corners beyond rounding to the grid.
        std::vector<char> moved(operands_.size(), bits > 0);
        rounded_.assign(operands_.size(), 0);
        const double largest = add_points(faces, frame, bits, soup, moved);
        add_faces(faces, soup, moved);
        add_twins(faces, soup);
        std::vector<std::size_t> n_faces(operands_.size(), 0);
        for (const auto& at : faces) ++n_faces[at.first];
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

    void forget_numbers(const std::vector<std::pair<Index, Index>>& faces)
    {
        if (place_.empty()) {
            place_.resize(operands_.size());
            vertex_.resize(operands_.size());
            for (std::size_t i = 0; i < operands_.size(); ++i) {
                place_[i].assign(ready_[i]->faces.size(), -1);
                vertex_[i].assign(mesh_of(i).vertices.size(), -1);
            }
        }
        for (const auto& [i, f] : faces) {
            place_[i][f] = -1;
            for (const Index v : ready_[i]->faces[f]) vertex_[i][v] = -1;
        }
    }

    // Returns the largest distance in steps that a coordinate is moved by.
    double add_points(const std::vector<std::pair<Index, Index>>& faces, const Frame& frame,
                      int bits, Soup& soup, std::vector<char>& moved)
    {
        double largest = 0.0;
        std::vector<Index> owner;  // of each point, an operand
        // A closed mesh of one piece has half as many corners as faces, and two.
        soup.points.reserve(faces.size() / 2 + 2 * operands_.size());
        owner.reserve(soup.points.capacity());
        for (const auto& [i, f] : faces)
            for (const Index v : ready_[i]->faces[f]) {
                if (vertex_[i][v] >= 0) continue;
                double off = 0.0;
                vertex_[i][v] = static_cast<Index>(soup.points.size());
                Vec3 p = frame.to_grid(mesh_of(i).vertices[v], off);
                if (bits > 0) {
                    const Vec3 q = frame.coarsened(p, bits);
                    for (int k = 0; k < 3; ++k) off = std::max(off, std::abs(q[k] - p[k]));
                    p = q;
                }
                soup.points.push_back(p);
                owner.push_back(i);
                if (off > 0.0) rounded_[i] = 1;
                largest = std::max(largest, off);
            }
        corners_.clear();
        corners_.reserve(faces.size());
        for (const auto& [i, f] : faces) {
            Triangle t = ready_[i]->faces[f];
            for (Index& v : t) v = vertex_[i][v];
            corners_.push_back(t);
        }
        const auto merged =
            exact::merge_close_coordinates(soup.points, corners_, frame.close(options_.most_snap));
        for (std::size_t n = 0; n < merged.size(); ++n) {
            if (merged[n] > 0.0) moved[owner[n]] = 1;
            largest = std::max(largest, merged[n]);
        }
        return largest;
    }

    void add_faces(const std::vector<std::pair<Index, Index>>& faces, Soup& soup,
                   std::vector<char>& moved)
    {
        soup.faces.reserve(faces.size());
        soup.operand.reserve(faces.size());
        soup.given.reserve(faces.size());
        for (std::size_t n = 0; n < faces.size(); ++n) {
            const auto [i, f] = faces[n];
            const Triangle& t = corners_[n];
            if (exact::is_flat(soup.points[t[0]], soup.points[t[1]], soup.points[t[2]])) {
                moved[i] = 1;
                continue;
            }
            place_[i][f] = static_cast<Index>(soup.faces.size());
            soup.faces.push_back(t);
            soup.operand.push_back(i);
            soup.given.push_back({i, ready_[i]->source.empty() ? f : ready_[i]->source[f]});
        }
        corners_ = {};
    }

    void add_twins(const std::vector<std::pair<Index, Index>>& faces, Soup& soup) const
    {
        soup.twin.reserve(3 * soup.faces.size());
        for (const auto& [i, f] : faces) {
            if (place_[i][f] < 0) continue;
            for (int k = 0; k < 3; ++k) {
                const Index h = ready_[i]->twin[3 * f + k];
                const Index at = h < 0 ? -1 : place_[i][h / 3];
                soup.twin.push_back(at < 0 ? -1 : 3 * at + h % 3);
            }
        }
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

    void append(const exact::Solved& solved, const Frame& frame)
    {
        IndexedMesh& mesh = result_.mesh;
        const auto base = static_cast<Index>(mesh.vertices.size());
        if (n_clusters_ == 1) {
            mesh.vertices.reserve(solved.points.size());
            mesh.faces.reserve(solved.faces.size());
            result_.operand.reserve(solved.faces.size());
            result_.source_face.reserve(solved.faces.size());
        }
        for (const Vec3& p : solved.points) mesh.vertices.push_back(frame.from_grid(p));
        for (const Triangle& t : solved.faces)
            mesh.faces.push_back({t[0] + base, t[1] + base, t[2] + base});
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
    std::vector<std::vector<std::pair<Index, Index>>> cluster_faces_;
    // By operand: moved by rounding to the grid; and all of it in this cluster, moved by no more.
    std::vector<char> rounded_;
    std::vector<char> whole_ = std::vector<char>(operands_.size(), 0);
    std::vector<Triangle> corners_;           // of the faces of a cluster
    std::vector<std::vector<Index>> place_;   // by operand and face: number in its soup
    std::vector<std::vector<Index>> vertex_;  // by operand and vertex: number in its soup
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
