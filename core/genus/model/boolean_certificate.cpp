#include "genus/model/boolean_certificate.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <utility>

#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/mesh/aabb_tree.h"

namespace genus {

namespace {

constexpr double kSmallest = 0.04;  // radius of a piece that must be settled, of the tolerance
// More pieces than this at one time, and than this many times those at the start, are given up.
constexpr std::size_t kMostPieces = 300'000, kGrowth = 2;
constexpr std::size_t kMostListed = 16;
constexpr double kRounding = 1.0 + 1e-12;

using Corners = std::array<Vec3, 3>;

// Inside, outside or not known: 1, 0, -1.
using Known = std::int8_t;

struct Piece {
    Corners p;
    std::int32_t operand;

    Vec3 center() const { return (p[0] + p[1] + p[2]) / 3.0; }
    double radius() const
    {
        const Vec3 c = center();
        return kRounding * std::max({distance(c, p[0]), distance(c, p[1]), distance(c, p[2])});
    }
    /// Halved across its longest side, which makes slivers compact.
    std::array<Piece, 2> parts() const
    {
        std::size_t k = 0;
        for (const std::size_t i : {1u, 2u})
            if (distance(p[i], p[(i + 1) % 3]) > distance(p[k], p[(k + 1) % 3])) k = i;
        const Vec3 &a = p[k], &b = p[(k + 1) % 3], &c = p[(k + 2) % 3];
        const Vec3 middle = 0.5 * (a + b);
        return {Piece{{a, middle, c}, operand}, Piece{{middle, b, c}, operand}};
    }
};

// The operands as far as they are known over balls.
class Scene {
public:
    Scene(std::span<const IndexedMesh> operands, const BooleanFormula& formula,
          std::span<const double> deviations, double rounding)
        : formula_(formula), deviations_(deviations), rounding_(rounding)
    {
        trees_.reserve(operands.size());
        std::vector<Box3> boxes;
        for (const IndexedMesh& mesh : operands) {
            trees_.emplace_back(mesh);
            if (mesh.faces.empty()) continue;
            numbers_.push_back(static_cast<std::int32_t>(trees_.size()) - 1);
            boxes.push_back(
                trees_.back().boxes().bounds().inflated(deviations[trees_.size() - 1] + rounding));
        }
        boxes_ = BoxTree(boxes);
    }

    double deviation(std::int32_t i) const { return deviations_[static_cast<std::size_t>(i)]; }

    struct Over {
        Known inside, outside;  // the formula if the own operand is
        bool exact;             // so are the own operand and all that are not known
    };
    /// The formula over a ball, for operand `own`.
    Over over(const Vec3& c, double radius, std::int32_t own) const
    {
        Over result{0, 0, deviation(own) == 0.0};
        std::vector<Known> known(trees_.size(), Known{0});
        Box3 ball;
        ball.add(c);
        boxes_.visit_overlapping(ball.inflated(radius), [&](std::int32_t item) {
            const std::int32_t j = numbers_[static_cast<std::size_t>(item)];
            if (j == own) return;
            const Known k = operand_over(j, c, radius);
            known[static_cast<std::size_t>(j)] = k;
            result.exact = result.exact && (k >= 0 || deviation(j) == 0.0);
        });
        known[static_cast<std::size_t>(own)] = 1;
        result.inside = value(known);
        known[static_cast<std::size_t>(own)] = 0;
        result.outside = value(known);
        return result;
    }

private:
    Known operand_over(std::int32_t j, const Vec3& c, double radius) const
    {
        const MeshTree& tree = trees_[static_cast<std::size_t>(j)];
        if (tree.nearest(c, kRounding * (radius + deviation(j) + rounding_)).face >= 0) return -1;
        const auto turns = tree.winding_number(c);
        return !turns ? Known{-1} : *turns != 0 ? Known{1} : Known{0};
    }

    Known value(const std::vector<Known>& known) const
    {
        if (formula_.instructions.empty()) return 0;
        std::vector<Known> values;
        for (const BooleanFormula::Instruction& op : formula_.instructions) {
            const Known settles = op.is_intersection ? Known{0} : Known{1};
            Known v = op.is_intersection ? Known{1} : Known{0};
            for (const BooleanFormula::Term& t : op.terms) {
                Known k = t.is_operand ? known[static_cast<std::size_t>(t.index)]
                                       : values[static_cast<std::size_t>(t.index)];
                if (t.negated && k >= 0) k = static_cast<Known>(1 - k);
                if (k == settles) {
                    v = settles;
                    break;
                }
                if (k < 0) v = -1;
            }
            values.push_back(v);
        }
        return values.back();
    }

    const BooleanFormula& formula_;
    std::span<const double> deviations_;
    double rounding_;
    std::vector<MeshTree> trees_;
    std::vector<std::int32_t> numbers_;  // operands of the boxes
    BoxTree boxes_;
};

class Proof {
public:
    Proof(const Scene& scene, double tolerance, BooleanCertificate& c)
        : scene_(scene), tolerance_(tolerance), c_(c)
    {
    }

    // From the result to the exact solid.
    void clear_pieces(const MeshBooleanResult& made)
    {
        std::vector<Piece> open;
        for (std::size_t f = 0; f < made.mesh.n_faces(); ++f)
            open.push_back({corners(made.mesh, f), made.operand[f]});
        n_start_ = open.size();
        bool first = true;
        while (!open.empty()) {
            if (too_many(open)) return;
            std::vector<char> is_clear(open.size(), 0);
            each(open.size(), [&](std::size_t i) { is_clear[i] = clear(open[i]) ? 1 : 0; });
            if (first) note_open_vertices(made.mesh, is_clear);
            std::vector<Piece> unclear = std::exchange(small_, {});
            for (std::size_t i = 0; i < open.size(); ++i) {
                if (is_clear[i] == 0)
                    unclear.push_back(open[i]);
                else
                    add_clear(open[i], !first || beside_open(made.mesh.faces[i]));
            }
            first = false;
            open.clear();
            settle(unclear, open);
            // A piece that is done may hold clear ones, nearer to those that are not.
            if (open.empty() && !small_.empty()) open = parts_of_done_near_small();
        }
        for (const Piece& piece : small_)
            if (c_.doubtful.size() < kMostListed) fail(piece);
    }

    // From the exact solid to the result.
    void near_pieces(std::span<const IndexedMesh> operands, const MeshTree& result)
    {
        std::vector<Piece> open;
        for (std::size_t i = 0; i < operands.size(); ++i)
            for (std::size_t f = 0; f < operands[i].n_faces(); ++f)
                open.push_back({corners(operands[i], f), static_cast<std::int32_t>(i)});
        n_start_ = open.size();
        while (!open.empty()) {
            if (too_many(open)) return;
            std::vector<double> reach(open.size(), kNever);
            each(open.size(), [&](std::size_t i) { reach[i] = near_or_settled(open[i], result); });
            std::vector<Piece> next;
            for (std::size_t i = 0; i < open.size(); ++i) {
                if (reach[i] < kNever) {
                    c_.bound = std::max(c_.bound, reach[i]);
                } else if (!divide(open[i], next)) {
                    fail(open[i]);
                    if (c_.doubtful.size() == kMostListed) return;
                }
            }
            open.swap(next);
        }
    }

private:
    static constexpr double kNever = std::numeric_limits<double>::infinity();

    static Corners corners(const IndexedMesh& mesh, std::size_t f)
    {
        const Triangle& t = mesh.faces[f];
        return {mesh.vertices[static_cast<std::size_t>(t[0])],
                mesh.vertices[static_cast<std::size_t>(t[1])],
                mesh.vertices[static_cast<std::size_t>(t[2])]};
    }

    void note_open_vertices(const IndexedMesh& mesh, const std::vector<char>& is_clear)
    {
        at_open_face_.assign(mesh.n_vertices(), 0);
        for (std::size_t f = 0; f < mesh.n_faces(); ++f)
            if (is_clear[f] == 0)
                for (const std::int32_t v : mesh.faces[f])
                    at_open_face_[static_cast<std::size_t>(v)] = 1;
    }
    bool beside_open(const Triangle& t) const
    {
        return std::any_of(t.begin(), t.end(), [&](std::int32_t v) {
            return at_open_face_[static_cast<std::size_t>(v)] != 0;
        });
    }

    template <class F>
    static void each(std::size_t n, const F& f)
    {
        parallel_for(n, 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) f(i);
        });
    }

    bool too_many(const std::vector<Piece>& open)
    {
        current_progress().check();
        c_.n_pieces += static_cast<std::int64_t>(open.size());
        if (open.size() + small_.size() <= std::max(kMostPieces, kGrowth * n_start_)) return false;
        fail(open.front());
        return true;
    }

    void fail(const Piece& piece)
    {
        Box3 box;
        for (const Vec3& p : piece.p) box.add(p);
        c_.doubtful.push_back(box);
    }

    bool may_divide(const Piece& piece) const { return piece.radius() > kSmallest * tolerance_; }

    // False if the piece is as small as pieces get.
    bool divide(const Piece& piece, std::vector<Piece>& next) const
    {
        if (!may_divide(piece)) return false;
        for (const Piece& part : piece.parts()) next.push_back(part);
        return true;
    }

    bool clear(const Piece& piece) const
    {
        const double e = scene_.deviation(piece.operand);
        const auto over = scene_.over(piece.center(), piece.radius() + e, piece.operand);
        return over.exact || (over.inside >= 0 && over.outside >= 0 && over.inside != over.outside);
    }

    void add_clear(const Piece& piece, bool may_be_near_others)
    {
        const double e = scene_.deviation(piece.operand);
        c_.bound = std::max(c_.bound, e);
        if (!may_be_near_others) return;
        const auto first = static_cast<std::int32_t>(clear_.vertices.size());
        clear_.vertices.insert(clear_.vertices.end(), piece.p.begin(), piece.p.end());
        clear_.faces.push_back({first, first + 1, first + 2});
        clear_deviation_.push_back(e);
    }

    // Pieces that are not clear: those with a clear one near enough are done, others divided.
    void settle(const std::vector<Piece>& pieces, std::vector<Piece>& next)
    {
        const MeshTree tree(clear_);
        std::vector<double> reach(pieces.size(), kNever);
        each(pieces.size(), [&](std::size_t i) {
            const double radius = pieces[i].radius();
            if (!(radius < tolerance_)) return;
            const ClosestPoint near = tree.nearest(pieces[i].center(), tolerance_ - radius);
            if (near.face < 0) return;
            const double far = kRounding * (near.distance + radius) +
                               clear_deviation_[static_cast<std::size_t>(near.face)];
            if (far <= tolerance_) reach[i] = far;
        });
        for (std::size_t i = 0; i < pieces.size(); ++i) {
            if (reach[i] < kNever) {
                c_.bound = std::max(c_.bound, reach[i]);
                if (may_divide(pieces[i])) done_.push_back(pieces[i]);
            } else if (!divide(pieces[i], next)) {
                small_.push_back(pieces[i]);
            }
        }
    }

    std::vector<Piece> parts_of_done_near_small()
    {
        IndexedMesh mesh;
        for (const Piece& piece : small_) {
            const auto first = static_cast<std::int32_t>(mesh.vertices.size());
            mesh.vertices.insert(mesh.vertices.end(), piece.p.begin(), piece.p.end());
            mesh.faces.push_back({first, first + 1, first + 2});
        }
        const MeshTree tree(mesh);
        std::vector<char> is_near(done_.size(), 0);
        each(done_.size(), [&](std::size_t i) {
            const double reach = done_[i].radius() + tolerance_;
            is_near[i] = tree.nearest(done_[i].center(), reach).face >= 0 ? 1 : 0;
        });
        std::vector<Piece> parts, rest;
        for (std::size_t i = 0; i < done_.size(); ++i) {
            if (is_near[i] != 0)
                divide(done_[i], parts);
            else
                rest.push_back(done_[i]);
        }
        done_ = std::move(rest);
        return parts;
    }

    // How far the surface of X may be from the result beside this piece: 0 if there is none.
    double near_or_settled(const Piece& piece, const MeshTree& result) const
    {
        const double e = scene_.deviation(piece.operand);
        const Vec3 c = piece.center();
        const double radius = piece.radius();
        const ClosestPoint near = result.nearest(c, radius + tolerance_);
        if (near.face >= 0) {
            // The distance from a convex set is largest at a corner.
            const Corners q = corners(result.mesh(), static_cast<std::size_t>(near.face));
            double far = 0.0;
            for (const Vec3& p : piece.p)
                far = std::max(far, distance(p, closest_point(p, q[0], q[1], q[2])));
            if (kRounding * far + e <= tolerance_) return kRounding * far + e;
        }
        const auto over = scene_.over(c, radius + e, piece.operand);
        const bool settled = over.exact || (over.inside >= 0 && over.inside == over.outside);
        return settled ? 0.0 : kNever;
    }

    const Scene& scene_;
    double tolerance_;
    BooleanCertificate& c_;
    std::size_t n_start_ = 0;
    std::vector<char> at_open_face_;  // by vertex of the result
    // Pieces that are clear, of faces that are not and their neighbours.
    IndexedMesh clear_;
    std::vector<double> clear_deviation_;
    std::vector<Piece> done_;   // not clear, with a clear one near enough, and not small
    std::vector<Piece> small_;  // with none, and as small as pieces get
};

}  // namespace

BooleanCertificate certify_boolean(std::span<const IndexedMesh> operands,
                                   const BooleanFormula& formula,
                                   std::span<const double> deviations, double rounding,
                                   const MeshBooleanResult& made, double tolerance)
{
    BooleanCertificate c;
    const Scene scene(operands, formula, deviations, rounding);
    Proof proof(scene, tolerance, c);
    proof.clear_pieces(made);
    if (c.doubtful.empty()) proof.near_pieces(operands, MeshTree(made.mesh));
    c.proven = c.doubtful.empty() && c.bound <= tolerance;
    return c;
}

}  // namespace genus
