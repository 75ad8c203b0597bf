#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "genus/base/box.h"
#include "genus/implicit/function.h"
#include "genus/implicit/quadratic_model.h"

namespace genus {

/// Which way the choices of a list of instructions go: min, max and abs by the sign of a
/// difference, floor, ceil, round and sign by their value. Choices by the same difference go
/// together: min(a, b) and abs(a - b) make two pieces, not four.
class ChoiceList {
public:
    explicit ChoiceList(const std::vector<Function::Instruction>& code);

    /// The number of the question that an instruction asks, -1 if it asks none.
    std::int32_t question(std::size_t instruction) const { return question_[instruction]; }
    /// True where the answer counts the other way round.
    bool turned(std::size_t instruction) const { return turned_[instruction] != 0; }
    /// True unless an instruction before this one asks the same.
    bool asks_first(std::size_t instruction) const { return asks_first_[instruction] != 0; }
    std::size_t n_questions() const { return n_questions_; }

private:
    std::vector<std::int32_t> question_;
    std::vector<char> turned_, asks_first_;
    std::size_t n_questions_ = 0;
};

/// Models of the smooth pieces that may give the value of a function somewhere in the box; empty
/// if there are more than eight, or one of them has no bounded second derivatives there.
///
/// Values, gradients and second derivatives are carried forward through the instructions as
/// intervals, at the middle of the box and over it. Some 10 interval operations an instruction, up
/// to 40 a product.
///
/// Implements [griewank2008], chapter 3 (forward mode), for second derivatives as in
/// [neumaier1990], chapter 2 (centred forms).
std::vector<QuadraticModel> quadratic_models(const std::vector<Function::Instruction>& code,
                                             const ChoiceList& choices, const Box3& box);

}  // namespace genus
