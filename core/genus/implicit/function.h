#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "genus/implicit/expression.h"
#include "genus/implicit/implicit.h"
#include "genus/implicit/quadratic_model.h"

namespace genus {

class ChoiceList;

/// An expression compiled to a list of instructions, equal subexpressions once. Where it is not
/// defined it counts as outside: the value is +infinity, the gradient zero.
///
/// A value costs an instruction each, less in a batch; a gradient, backwards from the result, two
/// to three times as much; bounds by interval arithmetic some ten times. Reading is safe from
/// many threads. Smooth pieces, see Implicit, are told apart up to 30 uses of min, max and abs.
///
/// Implements [griewank2008], chapter 3 (reverse mode; forward for bounds); [moore2009], chapters 5
/// and 6 (natural interval extension of a function and its gradient).
class Function final : public Implicit {
public:
    /// Throws InvalidInput for more than 10^6 different subexpressions. O(nodes).
    explicit Function(const Expression& expression);

    const Expression& expression() const { return expression_; }
    std::size_t n_instructions() const { return code_.size(); }

    double value(const Vec3& p) const override;
    void values(std::span<const Vec3> points, std::span<double> out) const override;
    Vec3 gradient(const Vec3& p) const override;
    Interval bound(const Box3& box) const override;
    IntervalVec3 gradient_bound(const Box3& box) const override;
    /// Models of the smooth pieces that may give the value somewhere in the box: empty if these are
    /// more than eight, or one of them has no bounded second derivatives there. Thirty to sixty
    /// times the cost of a value for one piece.
    std::vector<QuadraticModel> quadratic_models(const Box3& box) const;
    /// Errors of rounding in `value` at points of the box do not exceed this; infinite where no
    /// bound is known, as next to a pole or a jump.
    double rounding_error(const Box3& box) const;
    std::int32_t piece(const Vec3& p) const override;
    double piece_value(std::int32_t piece, const Vec3& p) const override;
    Vec3 piece_gradient(std::int32_t piece, const Vec3& p) const override;

    /// Same instructions, hence the same function.
    bool operator==(const Function& other) const { return code_ == other.code_; }
    std::uint64_t hash() const;

    /// Operands are numbers of earlier instructions; the last one is the result.
    struct Instruction {
        Operation operation;
        std::int32_t a = 0, b = 0;
        double number = 0.0;
        bool operator==(const Instruction&) const = default;
    };

private:
    const double* results(const Vec3& p, std::int32_t piece) const;
    double value_with(const Vec3& p, std::int32_t piece) const;
    Vec3 gradient_with(const Vec3& p, std::int32_t piece) const;
    bool takes_second(std::size_t instruction, std::int32_t piece) const;

    Expression expression_;
    std::vector<Instruction> code_;
    std::vector<std::int32_t> choices_;  // instructions min, max and abs
    std::shared_ptr<const ChoiceList> choice_list_;
};

}  // namespace genus
