#pragma once

#include <cstdint>
#include <vector>

namespace genus {

/// A boolean formula over operands: a list of instructions in order of evaluation, of which the
/// last one is the result. A term names an operand or an earlier instruction, negated or not. No
/// instructions at all: the empty set.
struct BooleanFormula {
    struct Term {
        std::int32_t index;  // of an operand or of an earlier instruction
        bool is_operand;
        bool negated;
    };
    struct Instruction {
        bool is_intersection;  // of the terms, else their union
        std::vector<Term> terms;
    };
    std::vector<Instruction> instructions;

    /// Appends an instruction and returns its number.
    std::int32_t add(bool is_intersection, std::vector<Term> terms);

    static BooleanFormula union_of(std::int32_t n_operands);
    static BooleanFormula intersection_of(std::int32_t n_operands);
    /// Operand 0 less all others.
    static BooleanFormula difference_of(std::int32_t n_operands);

    /// Throws InvalidInput if a term names what does not exist, an instruction has no terms, or a
    /// point outside all operands would be inside.
    void check(std::int32_t n_operands) const;
};

/// On which sides of an operand a formula has one value whatever the other operands are.
struct SettlingSides {
    bool inside = false;
    bool outside = false;
};
/// By operand; only what follows from the shape of the formula. O(terms).
std::vector<SettlingSides> settling_sides(const BooleanFormula& formula, std::int32_t n_operands);

/// The value of a formula while operands change one at a time. A change costs as many steps as
/// there are instructions whose value it changes.
class FormulaState {
public:
    /// All operands are false.
    FormulaState(const BooleanFormula& formula, std::int32_t n_operands);

    void set(std::int32_t operand, bool value);
    bool value() const { return !values_.empty() && values_.back(); }

private:
    struct Use {
        std::int32_t instruction;
        bool negated;
    };
    void spread(const std::vector<Use>& uses, bool value);

    std::vector<std::vector<Use>> uses_of_operand_;
    std::vector<std::vector<Use>> uses_of_instruction_;
    std::vector<std::int32_t> n_true_;    // terms that hold, by instruction
    std::vector<std::int32_t> n_needed_;  // how many make it true
    std::vector<char> values_;
};

}  // namespace genus
