#include "genus/mesh/strips.h"

#include <array>

#include "genus/base/error.h"
#include "genus/mesh/sides.h"
#include "genus/mesh/triangle_list.h"

namespace genus {

namespace {

class StripMaker {
public:
    explicit StripMaker(const IndexedMesh& mesh)
        : mesh_(mesh), sides_(mesh), seen_(mesh.n_faces(), 0), used_(mesh.n_faces(), 0)
    {
        check_indices(sides_, mesh.n_vertices());
        require(mesh.n_faces() < (std::size_t{1} << 29), "to_strips: more than 2^29 faces");
        const EdgeTable table =
            make_edge_table(sides_, mesh.n_vertices(), [](std::size_t) { return false; });
        twin_ = twins(table, sides_.n_sides());
        // A strip can only go on into a face that turns the same way.
        for (std::size_t s = 0; s < twin_.size(); ++s) {
            const auto side = static_cast<std::int32_t>(s);
            if (twin_[s] >= 0 && sides_.from(side) == sides_.from(twin_[s])) twin_[s] = kNoEdge;
        }
    }

    TriangleStrips run()
    {
        for (std::size_t f = 0; f < mesh_.n_faces(); ++f) offer(static_cast<std::int32_t>(f));
        // A face moves to a lower pile when a neighbour goes; what is out of date is passed over.
        while (true) {
            std::size_t pile = 0;
            while (pile < 4 && piles_[pile].empty()) ++pile;
            if (pile == 4) break;
            const std::int32_t face = piles_[pile].back();
            piles_[pile].pop_back();
            if (!used_[face] && free_neighbours(face) == pile) take_strip(face);
        }
        return std::move(strips_);
    }

private:
    bool is_free(std::int32_t side) const { return side >= 0 && !used_[sides_.face(side)]; }

    std::size_t free_neighbours(std::int32_t face) const
    {
        std::size_t n = 0;
        for (std::int32_t s = 3 * face; s < 3 * face + 3; ++s) n += is_free(twin_[s]);
        return n;
    }

    void offer(std::int32_t face) { piles_[free_neighbours(face)].push_back(face); }

    // Calls `visit(entered side)` for the faces that follow, when the first one is left by `exit`.
    // From face to face the exit is by turns the side before and the side after the entered one.
    template <class Visit>
    std::int32_t follow(std::int32_t exit, Visit&& visit)
    {
        const std::int32_t mark = ++last_mark_;
        seen_[sides_.face(exit)] = mark;
        std::int32_t length = 1;
        for (bool back = true; is_free(twin_[exit]) && seen_[sides_.face(twin_[exit])] != mark;
             back = !back) {
            const std::int32_t entered = twin_[exit];
            seen_[sides_.face(entered)] = mark;
            visit(entered);
            ++length;
            exit = back ? sides_.previous(entered) : sides_.next(entered);
        }
        return length;
    }

    void take_strip(std::int32_t face)
    {
        std::int32_t best = 3 * face, longest = 0;
        for (std::int32_t exit = 3 * face; exit < 3 * face + 3; ++exit) {
            const std::int32_t length = follow(exit, [](std::int32_t) {});
            if (length <= longest) continue;
            longest = length;
            best = exit;
        }
        std::vector<std::int32_t> taken{face};
        add_point(sides_.from(sides_.previous(best)));
        add_point(sides_.from(best));
        add_point(sides_.to(best));
        follow(best, [&](std::int32_t entered) {
            taken.push_back(sides_.face(entered));
            add_point(sides_.from(sides_.previous(entered)));
        });
        strips_.starts.push_back(static_cast<std::int32_t>(strips_.points.size()));
        for (const std::int32_t f : taken) used_[f] = 1;
        for (const std::int32_t f : taken)
            for (std::int32_t s = 3 * f; s < 3 * f + 3; ++s)
                if (is_free(twin_[s])) offer(sides_.face(twin_[s]));
        current_progress().check();
    }

    void add_point(std::int32_t v) { strips_.points.push_back(mesh_.vertices[v]); }

    const IndexedMesh& mesh_;
    TriangleSides sides_;
    std::vector<std::int32_t> twin_;
    std::vector<std::int32_t> seen_;  // mark of the last strip tried through a face
    std::vector<std::uint8_t> used_;
    std::int32_t last_mark_ = 0;
    std::array<std::vector<std::int32_t>, 4> piles_;
    TriangleStrips strips_;
};

}  // namespace

TriangleStrips to_strips(const IndexedMesh& mesh)
{
    return StripMaker(mesh).run();
}

IndexedMesh to_indexed(const TriangleStrips& strips)
{
    TriangleList list;
    list.triangles.reserve(strips.n_faces());
    for (std::size_t s = 0; s < strips.n_strips(); ++s)
        for (std::int32_t i = strips.starts[s]; i + 2 < strips.starts[s + 1]; ++i) {
            const bool turned = (i - strips.starts[s]) % 2 == 1;
            const Vec3 &a = strips.points[i], &b = strips.points[i + 1], &c = strips.points[i + 2];
            list.triangles.push_back(turned ? std::array{b, a, c} : std::array{a, b, c});
        }
    return to_indexed(list);
}

}  // namespace genus
