#include "genus/model/sign_formula.h"

#include <algorithm>

namespace genus {

namespace {

constexpr std::size_t kFewSurfaces = 8;

// What a node has become: a constant, or a term of the new formula.
struct Value {
    Sign constant;
    std::int32_t term;
};

bool names_surface(std::int32_t term)
{
    return term >= 0;
}
std::int32_t number(std::int32_t term)
{
    return (term >= 0 ? term : ~term) >> 1;
}
bool negated(std::int32_t term)
{
    return ((term >= 0 ? term : ~term) & 1) != 0;
}
std::int32_t negate(std::int32_t term)
{
    return term >= 0 ? term ^ 1 : ~(~term ^ 1);
}

}  // namespace

SignFormula::SignFormula(Sign constant) : constant_(constant)
{
    static const auto nothing = std::make_shared<const Parts>();
    parts_ = nothing;
}

SignFormula::SignFormula(const CsgField& field)
{
    Parts parts;
    for (const CsgField::Instruction& instruction : field.instructions()) {
        const auto first = static_cast<std::int32_t>(parts.terms.size());
        for (const CsgField::Term& t : instruction.terms) {
            const std::int32_t code = 2 * t.index + (t.negated ? 1 : 0);
            parts.terms.push_back(t.is_surface ? code : ~code);
        }
        parts.nodes.push_back(
            {instruction.is_max, first, static_cast<std::int32_t>(instruction.terms.size())});
    }
    if (parts.nodes.empty()) {
        *this = SignFormula(Sign{1});
        return;
    }
    parts_ = std::make_shared<const Parts>(std::move(parts));
    // Constants hidden in empty instructions are folded by the same pass as known signs.
    *this = folded(std::vector<Sign>(field.surfaces().size(), Sign{0}));
}

struct SignFormula::Memory::Entry {
    std::uint32_t signs;
    int n;  // entries from here on
    SignFormula became;
    const Entry* next;
};

SignFormula::Memory::~Memory()
{
    for (const Entry* entry = first_.load(); entry != nullptr;) {
        const Entry* next = entry->next;
        delete entry;
        entry = next;
    }
}

const SignFormula* SignFormula::Memory::find(std::uint32_t signs) const
{
    for (const Entry* entry = first_.load(std::memory_order_acquire); entry != nullptr;
         entry = entry->next)
        if (entry->signs == signs) return &entry->became;
    return nullptr;
}

void SignFormula::Memory::add(std::uint32_t signs, const SignFormula& became) const
{
    constexpr int kMost = 64;
    const Entry* first = first_.load(std::memory_order_acquire);
    auto entry = std::make_unique<Entry>(Entry{signs, 0, became, nullptr});
    do {
        if (first != nullptr && first->n == kMost) return;
        entry->n = first != nullptr ? first->n + 1 : 1;
        entry->next = first;
    } while (!first_.compare_exchange_weak(first, entry.get(), std::memory_order_acq_rel,
                                           std::memory_order_acquire));
    entry.release();
}

SignFormula SignFormula::simplified(std::span<const Sign> signs) const
{
    if (constant_ != 0) return *this;
    if (surfaces().size() > kFewSurfaces) return simplified_anew(signs);
    std::uint32_t key = 0;
    bool any = false;
    for (const std::int32_t s : surfaces()) {
        key = 4 * key + static_cast<std::uint32_t>(signs[s] + 1);
        any = any || signs[s] != 0;
    }
    if (!any && !parts_->any_repeated) return *this;
    if (const SignFormula* known = parts_->memory.find(key)) return *known;
    SignFormula result = simplified_anew(signs);
    // One that remembered itself would never go.
    if (result.parts_ != parts_) parts_->memory.add(key, result);
    return result;
}

SignFormula SignFormula::simplified_anew(std::span<const Sign> signs) const
{
    if (const Sign known = sign(signs); known != 0) return SignFormula(known);
    const bool any = std::any_of(surfaces().begin(), surfaces().end(),
                                 [&](std::int32_t s) { return signs[s] != 0; });
    SignFormula result = any ? folded(signs) : *this;
    const bool small = result.surfaces().size() <= kFewSurfaces;
    return small && result.parts_->any_repeated ? result.with_true_uses() : result;
}

// The sign for each combination of signs; bit j of the place says "outside surface j".
std::vector<Sign> SignFormula::table() const
{
    const std::size_t n = surfaces().size();
    std::vector<Sign> signs(static_cast<std::size_t>(surfaces().back()) + 1, Sign{0});
    std::vector<Sign> result(std::size_t{1} << n);
    for (std::size_t bits = 0; bits < result.size(); ++bits) {
        for (std::size_t j = 0; j < n; ++j)
            signs[surfaces()[j]] = (bits >> j & 1) != 0 ? Sign{1} : Sign{-1};
        result[bits] = sign(signs);
    }
    return result;
}

// What is written both ways may still act one way, and what is written next to something that is
// written twice not at all.
SignFormula SignFormula::with_true_uses() const
{
    const std::vector<Sign> result = table();
    std::vector<Sign> idle(static_cast<std::size_t>(surfaces().back()) + 1, Sign{0});
    Parts refined = *parts_;
    refined.any_repeated = false;
    bool any_idle = false;
    for (std::size_t j = 0; j < surfaces().size(); ++j) {
        Use& use = refined.uses[j];
        use.plain = use.negated = false;
        const std::size_t bit = std::size_t{1} << j;
        for (std::size_t bits = 0; bits < result.size(); ++bits) {
            if ((bits & bit) != 0) continue;
            use.plain = use.plain || result[bits] < result[bits | bit];
            use.negated = use.negated || result[bits] > result[bits | bit];
        }
        if (use.plain || use.negated) continue;
        idle[surfaces()[j]] = 1;
        any_idle = true;
    }
    return any_idle ? folded(idle).simplified(idle) : SignFormula(std::move(refined));
}

Sign SignFormula::sign_by_cases(std::vector<Sign>& signs) const
{
    const Sign known = sign(signs);
    if (known != 0) return known;
    for (std::size_t i = 0; i < surfaces().size(); ++i) {
        Sign& s = signs[surfaces()[i]];
        if (s != 0 || !uses()[i].twice) continue;
        s = -1;
        const Sign inside = sign_by_cases(signs);
        s = 1;
        const Sign both = inside != 0 && sign_by_cases(signs) == inside ? inside : Sign{0};
        s = 0;
        return both;
    }
    return 0;
}

SignFormula SignFormula::folded(std::span<const Sign> signs) const
{
    if (constant_ != 0) return *this;
    const std::vector<Node>& nodes = parts_->nodes;
    const std::vector<std::int32_t>& terms = parts_->terms;
    Parts result;
    std::vector<Value> values(nodes.size());
    std::vector<std::int32_t> kept;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        const Node& node = nodes[n];
        const Sign decides = node.is_max ? 1 : -1;
        kept.clear();
        bool decided = false;
        for (std::int32_t i = node.first; i < node.first + node.count && !decided; ++i) {
            const std::int32_t term = terms[i];
            Value v =
                names_surface(term) ? Value{signs[number(term)], term & ~1} : values[number(term)];
            if (negated(term)) v = {static_cast<Sign>(-v.constant), negate(v.term)};
            if (v.constant == 0)
                kept.push_back(v.term);
            else
                decided = v.constant == decides;
        }
        if (decided || kept.empty()) {
            values[n] = {decided ? decides : static_cast<Sign>(-decides), 0};
        } else if (kept.size() == 1) {
            values[n] = {0, kept[0]};
        } else {
            const auto first = static_cast<std::int32_t>(result.terms.size());
            const auto self = static_cast<std::int32_t>(result.nodes.size());
            result.terms.insert(result.terms.end(), kept.begin(), kept.end());
            result.nodes.push_back({node.is_max, first, static_cast<std::int32_t>(kept.size())});
            values[n] = {0, ~(2 * self)};
        }
    }
    const Value& root = values.back();
    if (root.constant != 0) return SignFormula(root.constant);
    // The result is the last node, so a bare or negated reference gets a node of its own.
    const auto last = static_cast<std::int32_t>(result.nodes.size()) - 1;
    if (names_surface(root.term) || negated(root.term) || number(root.term) != last) {
        result.nodes.push_back({true, static_cast<std::int32_t>(result.terms.size()), 1});
        result.terms.push_back(root.term);
    }
    result.note_surfaces();
    return SignFormula(std::move(result));
}

void SignFormula::Parts::note_surfaces()
{
    // Only what the result reaches counts: nodes may have lost their last use.
    struct Reach {
        bool plain = false, negated = false;
    };
    std::vector<Reach> reach(nodes.size());
    reach.back().plain = true;
    std::vector<std::pair<std::int32_t, bool>> found;
    for (std::size_t n = nodes.size(); n-- > 0;) {
        const Reach r = reach[n];
        if (!r.plain && !r.negated) continue;
        for (std::int32_t i = nodes[n].first; i < nodes[n].first + nodes[n].count; ++i) {
            const std::int32_t term = terms[i];
            const bool flip = negated(term);
            const Reach below{flip ? r.negated : r.plain, flip ? r.plain : r.negated};
            if (names_surface(term)) {
                if (below.plain) found.push_back({number(term), false});
                if (below.negated) found.push_back({number(term), true});
            } else {
                reach[number(term)].plain |= below.plain;
                reach[number(term)].negated |= below.negated;
            }
        }
    }
    std::sort(found.begin(), found.end());
    for (std::size_t i = 0; i < found.size(); ++i) {
        const auto& [surface, is_negated] = found[i];
        any_repeated = any_repeated || (i > 0 && found[i - 1].first == surface);
        if (surfaces.empty() || surfaces.back() != surface) {
            surfaces.push_back(surface);
            uses.emplace_back();
        }
        Use& use = uses.back();
        (is_negated ? use.negated : use.plain) = true;
        use.twice = use.plain && use.negated;
    }
}

Sign SignFormula::sign(std::span<const Sign> signs) const
{
    if (constant_ != 0) return constant_;
    const std::vector<Node>& nodes = parts_->nodes;
    constexpr std::size_t kSmall = 64;
    Sign small[kSmall];
    std::vector<Sign> large(nodes.size() > kSmall ? nodes.size() : 0);
    Sign* value = nodes.size() > kSmall ? large.data() : small;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        const Node& node = nodes[n];
        const Sign decides = node.is_max ? 1 : -1;
        Sign result = static_cast<Sign>(-decides);
        for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
            const std::int32_t term = parts_->terms[i];
            Sign s = names_surface(term) ? signs[number(term)] : value[number(term)];
            if (negated(term)) s = static_cast<Sign>(-s);
            if (s == decides) {
                result = decides;
                break;
            }
            if (s == 0) result = 0;
        }
        value[n] = result;
    }
    return value[nodes.size() - 1];
}

}  // namespace genus
