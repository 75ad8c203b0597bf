#include "genus/model/csg_field.h"

#include <algorithm>
#include <array>
#include <limits>

#include "genus/model/csg_lowering.h"

namespace genus {
namespace {

using Term = CsgField::Term;
using Instruction = CsgField::Instruction;
using Active = CsgField::Active;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// One T an instruction, on the stack for all but long formulas.
template <class T>
class Scratch {
public:
    explicit Scratch(std::size_t n)
    {
        if (n > few_.size()) {
            many_.resize(n);
            at_ = many_.data();
        }
    }
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;
    T& operator[](std::size_t i) { return at_[i]; }

private:
    std::array<T, 16> few_;
    std::vector<T> many_;
    T* at_ = few_.data();
};

double value_of(const std::vector<Surface>& surfaces, const std::vector<Instruction>& code,
                const Vec3& p)
{
    Scratch<double> values(code.size());
    for (std::size_t i = 0; i < code.size(); ++i) {
        double best = code[i].is_max ? -kInfinity : kInfinity;
        for (const Term& t : code[i].terms) {
            const double raw = t.is_surface ? surfaces[t.index].value(p) : values[t.index];
            const double v = t.negated ? -raw : raw;
            best = code[i].is_max ? std::max(best, v) : std::min(best, v);
        }
        values[i] = best;
    }
    return values[code.size() - 1];
}

Active active_of(const std::vector<Surface>& surfaces, const std::vector<Instruction>& code,
                 const Vec3& p)
{
    Scratch<Active> found(code.size());
    for (std::size_t i = 0; i < code.size(); ++i) {
        Active best{-1, 0.0, code[i].is_max ? -kInfinity : kInfinity};
        for (const Term& t : code[i].terms) {
            Active a =
                t.is_surface ? Active{t.index, 1.0, surfaces[t.index].value(p)} : found[t.index];
            if (t.negated) a = {a.surface, -a.sign, -a.value};
            // The first of equal values wins, so that the answer does not depend on pruning.
            if (&t == code[i].terms.data() ||
                (code[i].is_max ? a.value > best.value : a.value < best.value))
                best = a;
        }
        found[i] = best;
    }
    return found[code.size() - 1];
}

Interval signed_bound(const Interval& bound, bool negated)
{
    return negated ? -bound : bound;
}

/// Bounds of all terms and instructions over a box, and what of it matters there.
struct Analysis {
    std::vector<std::vector<Interval>> terms;  // as the terms enter, sign included
    std::vector<Interval> results;
    std::vector<char> live;  // instructions that may decide the result

    /// A max is never decided by a term that ends below where another begins; a min likewise.
    bool decides(const Instruction& op, std::size_t i, std::size_t k) const
    {
        return op.is_max ? terms[i][k].hi >= results[i].lo : terms[i][k].lo <= results[i].hi;
    }
};

Analysis analyse(const std::vector<Surface>& surfaces, const std::vector<Instruction>& code,
                 const Box3& box)
{
    Analysis a;
    a.terms.resize(code.size());
    a.results.resize(code.size());
    for (std::size_t i = 0; i < code.size(); ++i) {
        const double least = code[i].is_max ? -kInfinity : kInfinity;
        Interval result(least, least);
        a.terms[i].reserve(code[i].terms.size());
        for (const Term& t : code[i].terms) {
            const Interval raw = t.is_surface ? surfaces[t.index].bound(box) : a.results[t.index];
            const Interval bound = signed_bound(raw, t.negated);
            a.terms[i].push_back(bound);
            result = code[i].is_max ? max(result, bound) : min(result, bound);
        }
        a.results[i] = result;
    }
    a.live.assign(code.size(), 0);
    if (!code.empty()) a.live.back() = 1;
    for (std::size_t i = code.size(); i-- > 0;) {
        if (!a.live[i]) continue;
        for (std::size_t k = 0; k < code[i].terms.size(); ++k)
            if (!code[i].terms[k].is_surface && a.decides(code[i], i, k))
                a.live[code[i].terms[k].index] = 1;
    }
    return a;
}

/// The live instructions with the terms that may decide. One of a single term melts into the
/// instruction above it.
std::vector<Instruction> shortened(const std::vector<Instruction>& code, const Analysis& a)
{
    std::vector<Instruction> result;
    std::vector<Term> stands_for(code.size());  // what an instruction became
    for (std::size_t i = 0; i < code.size(); ++i) {
        if (!a.live[i]) continue;
        Instruction op{code[i].is_max, {}};
        for (std::size_t k = 0; k < code[i].terms.size(); ++k) {
            if (!a.decides(code[i], i, k)) continue;
            Term t = code[i].terms[k];
            if (!t.is_surface) {
                const Term inner = stands_for[t.index];
                t = {inner.index, inner.is_surface, inner.negated != t.negated};
            }
            op.terms.push_back(t);
        }
        if (op.terms.size() == 1 && i + 1 < code.size()) {
            stands_for[i] = op.terms[0];
            continue;
        }
        stands_for[i] = {static_cast<std::int32_t>(result.size()), false, false};
        result.push_back(std::move(op));
    }
    return result;
}

CsgField::Pruned pruned(const std::vector<Surface>& surfaces, const std::vector<Instruction>& code,
                        const Box3& box)
{
    const Analysis a = analyse(surfaces, code, box);
    if (a.results.back().lo > 0.0) return {{}, 1};
    if (a.results.back().hi < 0.0) return {{}, -1};
    return {shortened(code, a), 0};
}

IntervalVec3 gradients(const std::vector<Surface>& surfaces, const std::vector<Instruction>& code,
                       const Box3& box)
{
    const Analysis a = analyse(surfaces, code, box);
    // An instruction may be reached with either sign.
    std::vector<std::array<char, 2>> reached(code.size(), {0, 0});
    reached.back()[0] = 1;
    constexpr Interval none(kInfinity, -kInfinity);
    IntervalVec3 sum{none, none, none};
    for (std::size_t i = code.size(); i-- > 0;) {
        for (int sign = 0; sign < 2; ++sign) {
            if (!reached[i][sign]) continue;
            for (std::size_t k = 0; k < code[i].terms.size(); ++k) {
                if (!a.decides(code[i], i, k)) continue;
                const Term& t = code[i].terms[k];
                const bool negated = t.negated != (sign == 1);
                if (!t.is_surface) {
                    reached[t.index][negated] = 1;
                    continue;
                }
                const IntervalVec3 g = surfaces[t.index].gradient_bound(box);
                for (int c = 0; c < 3; ++c) sum[c] = hull(sum[c], signed_bound(g[c], negated));
            }
        }
    }
    return sum;
}

Active constant(int sign)
{
    return {-1, 0.0, sign < 0 ? -kInfinity : kInfinity};
}

}  // namespace

Interval Surface::bound(const Box3& box) const
{
    if (kind == Kind::Function) return function->bound(box);
    return kind == Kind::Torus ? Interval(torus_scale) * torus->bound(box) : quadric.bound(box);
}

IntervalVec3 Surface::gradient_bound(const Box3& box) const
{
    if (kind == Kind::Function) return function->gradient_bound(box);
    if (kind != Kind::Torus) return quadric.gradient_bound(box);
    IntervalVec3 g = torus->gradient_bound(box);
    for (Interval& c : g) c = Interval(torus_scale) * c;
    return g;
}

namespace {

std::size_t count_terms(const std::vector<Instruction>& code)
{
    std::size_t n = 0;
    for (const Instruction& i : code) n += i.terms.size();
    return n;
}

// A field inside a box. Pieces are told by the whole field, whose numbers they have.
class FieldWithin final : public Implicit {
public:
    FieldWithin(const CsgField& whole, CsgField::Pruned&& here)
        : whole_(whole), here_(std::move(here))
    {
    }

    static std::shared_ptr<const Implicit> make(const CsgField& whole, CsgField::Pruned&& here,
                                                std::size_t n_terms)
    {
        if (here.constant_sign != 0 || count_terms(here.instructions) >= n_terms) return nullptr;
        return std::make_shared<const FieldWithin>(whole, std::move(here));
    }

    double value(const Vec3& p) const override { return whole_.value(here_, p); }
    Vec3 gradient(const Vec3& p) const override { return whole_.gradient(here_, p); }
    Interval bound(const Box3& box) const override { return whole_.bound(here_, box); }
    IntervalVec3 gradient_bound(const Box3& box) const override
    {
        return whole_.gradient_bound(here_, box);
    }
    std::shared_ptr<const Implicit> within(const Box3& box) const override
    {
        return make(whole_, whole_.prune(here_, box), count_terms(here_.instructions));
    }
    std::int32_t piece(const Vec3& p) const override { return whole_.piece(p); }
    double piece_value(std::int32_t piece, const Vec3& p) const override
    {
        return whole_.piece_value(piece, p);
    }
    Vec3 piece_gradient(std::int32_t piece, const Vec3& p) const override
    {
        return whole_.piece_gradient(piece, p);
    }

private:
    const CsgField& whole_;
    CsgField::Pruned here_;
};

}  // namespace

std::shared_ptr<const Implicit> CsgField::within(const Box3& box) const
{
    if (instructions_.empty()) return nullptr;
    return FieldWithin::make(*this, prune(box), count_terms(instructions_));
}

CsgField::CsgField(const Solid& solid)
{
    LoweredTree tree = lower(solid);
    surfaces_ = std::move(tree.surfaces);
    instructions_ = std::move(tree.instructions);
}

double CsgField::value(const Vec3& p) const
{
    return instructions_.empty() ? kInfinity : value_of(surfaces_, instructions_, p);
}

CsgField::Active CsgField::active(const Vec3& p) const
{
    return instructions_.empty() ? constant(1) : active_of(surfaces_, instructions_, p);
}

Vec3 CsgField::gradient(const Vec3& p) const
{
    const Active a = active(p);
    return a.surface < 0 ? Vec3{} : a.sign * surfaces_[a.surface].gradient(p);
}

// Piece n of surface s has the number s + n * surfaces.
std::int32_t CsgField::piece(const Vec3& p) const
{
    const std::int32_t s = active(p).surface;
    if (s < 0 || !surfaces_[s].function) return s;
    const std::int64_t own = surfaces_[s].function->piece(p);
    const std::int64_t number = s + own * static_cast<std::int64_t>(surfaces_.size());
    return own < 0 || number > std::numeric_limits<std::int32_t>::max()
               ? -1
               : static_cast<std::int32_t>(number);
}

double CsgField::piece_value(std::int32_t piece, const Vec3& p) const
{
    const auto n = static_cast<std::int32_t>(surfaces_.size());
    const Surface& s = surfaces_[piece % n];
    return s.function ? s.function->piece_value(piece / n, p) : s.value(p);
}

Vec3 CsgField::piece_gradient(std::int32_t piece, const Vec3& p) const
{
    const auto n = static_cast<std::int32_t>(surfaces_.size());
    const Surface& s = surfaces_[piece % n];
    return s.function ? s.function->piece_gradient(piece / n, p) : s.gradient(p);
}

Interval CsgField::bound(const Box3& box) const
{
    if (instructions_.empty()) return Interval(kInfinity);
    return analyse(surfaces_, instructions_, box).results.back();
}

IntervalVec3 CsgField::gradient_bound(const Box3& box) const
{
    if (instructions_.empty()) return {};
    return gradients(surfaces_, instructions_, box);
}

CsgField::Pruned CsgField::prune(const Box3& box) const
{
    if (instructions_.empty()) return {{}, 1};
    return pruned(surfaces_, instructions_, box);
}

CsgField::Pruned CsgField::prune(const Pruned& coarser, const Box3& box) const
{
    if (coarser.instructions.empty()) return coarser;
    return pruned(surfaces_, coarser.instructions, box);
}

double CsgField::value(const Pruned& part, const Vec3& p) const
{
    if (part.instructions.empty()) return constant(part.constant_sign).value;
    return value_of(surfaces_, part.instructions, p);
}

CsgField::Active CsgField::active(const Pruned& part, const Vec3& p) const
{
    if (part.instructions.empty()) return constant(part.constant_sign);
    return active_of(surfaces_, part.instructions, p);
}

Vec3 CsgField::gradient(const Pruned& part, const Vec3& p) const
{
    const Active a = active(part, p);
    return a.surface < 0 ? Vec3{} : a.sign * surfaces_[a.surface].gradient(p);
}

Interval CsgField::bound(const Pruned& part, const Box3& box) const
{
    if (part.instructions.empty()) return Interval(constant(part.constant_sign).value);
    return analyse(surfaces_, part.instructions, box).results.back();
}

IntervalVec3 CsgField::gradient_bound(const Pruned& part, const Box3& box) const
{
    if (part.instructions.empty()) return {};
    return gradients(surfaces_, part.instructions, box);
}

std::vector<std::int32_t> CsgField::surfaces_of(const Pruned& part)
{
    std::vector<std::int32_t> numbers;
    for (const Instruction& op : part.instructions)
        for (const Term& t : op.terms)
            if (t.is_surface) numbers.push_back(t.index);
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    return numbers;
}

}  // namespace genus
