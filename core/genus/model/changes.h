#pragma once

#include <cstdint>
#include <vector>

#include "genus/model/flexible_mesh.h"

namespace genus {

/// Where a mesh was changed in this round or the one before: what was refused elsewhere would be
/// refused again, so a sweep over all edges need not try it. All is changed in the first round.
class Changes {
public:
    explicit Changes(const FlexibleMesh& mesh) : m_(mesh), round_of_(mesh.n_vertices(), 0) {}

    void next_round() { ++round_; }
    /// At an end of the edge, for what depends on the faces round its ends.
    bool at_edge(std::int32_t s) const { return at(m_.from(s)) || at(m_.to(s)); }
    /// At a corner of one of its two faces, for what depends on these.
    bool round_edge(std::int32_t s) const
    {
        return at_edge(s) || at(m_.apex(s)) || at(m_.apex(m_.twin(s)));
    }
    /// One of these vertices has gone into the other.
    void note_collapse(std::int32_t a, std::int32_t b)
    {
        if (m_.touches(a) || m_.touches(b)) all_since_ = round_;
        const std::int32_t v = m_.exists(a) ? a : b;
        round_of_[v] = round_;
        if (m_.exists(v)) note_ring(v);
    }
    void note_flip(std::int32_t s)
    {
        for (const std::int32_t v : {m_.from(s), m_.to(s), m_.apex(s), m_.apex(m_.twin(s))})
            round_of_[v] = round_;
    }
    /// A vertex was moved.
    void note_move(std::int32_t v)
    {
        round_of_[v] = round_;
        note_ring(v);
    }

private:
    bool at(std::int32_t v) const { return round_of_[v] + 1 >= round_ || all_since_ + 1 >= round_; }
    void note_ring(std::int32_t v)
    {
        m_.visit_ring(v, [&](std::int32_t s) { round_of_[m_.to(s)] = round_; });
    }

    const FlexibleMesh& m_;
    std::int32_t round_ = 0, all_since_ = -2;
    std::vector<std::int32_t> round_of_;
};

}  // namespace genus
