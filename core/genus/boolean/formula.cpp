#include "genus/boolean/formula.h"

#include <string>
#include <utility>

#include "genus/base/error.h"

namespace genus {

std::int32_t BooleanFormula::add(bool is_intersection, std::vector<Term> terms)
{
    instructions.push_back({is_intersection, std::move(terms)});
    return static_cast<std::int32_t>(instructions.size()) - 1;
}

namespace {

BooleanFormula one_step(bool is_intersection, bool negate_others, std::int32_t n_operands)
{
    BooleanFormula formula;
    if (n_operands <= 0) return formula;
    std::vector<BooleanFormula::Term> terms;
    for (std::int32_t i = 0; i < n_operands; ++i)
        terms.push_back({i, true, negate_others && i > 0});
    formula.add(is_intersection, std::move(terms));
    return formula;
}

}  // namespace

BooleanFormula BooleanFormula::union_of(std::int32_t n_operands)
{
    return one_step(false, false, n_operands);
}

BooleanFormula BooleanFormula::intersection_of(std::int32_t n_operands)
{
    return one_step(true, false, n_operands);
}

BooleanFormula BooleanFormula::difference_of(std::int32_t n_operands)
{
    return one_step(true, true, n_operands);
}

void BooleanFormula::check(std::int32_t n_operands) const
{
    for (std::size_t i = 0; i < instructions.size(); ++i) {
        const std::string where = "mesh_boolean: formula, instruction " + std::to_string(i);
        if (instructions[i].terms.empty()) throw InvalidInput(where + " has no terms");
        for (const Term& term : instructions[i].terms) {
            const std::int32_t end = term.is_operand ? n_operands : static_cast<std::int32_t>(i);
            if (term.index < 0 || term.index >= end)
                throw InvalidInput(
                    where + " names " + (term.is_operand ? "operand " : "instruction ") +
                    std::to_string(term.index) + ", there are " + std::to_string(end));
        }
    }
    if (FormulaState(*this, n_operands).value())
        throw InvalidInput("mesh_boolean: the formula holds outside all operands");
}

std::vector<SettlingSides> settling_sides(const BooleanFormula& formula, std::int32_t n_operands)
{
    std::vector<SettlingSides> sides(n_operands);
    if (formula.instructions.empty()) return sides;
    // Values of instructions that would settle the last one, found from there downwards: one term
    // settles an intersection at false, a union at true.
    std::vector<SettlingSides> wanted(formula.instructions.size());  // true, false
    wanted.back() = {true, true};
    const auto spread = [&](const BooleanFormula::Instruction& instruction, bool value) {
        const bool one_is_enough =
            instruction.terms.size() == 1 || value != instruction.is_intersection;
        for (const auto& term : instruction.terms) {
            if (!one_is_enough) break;
            auto& side = term.is_operand ? sides[term.index] : wanted[term.index];
            (value != term.negated ? side.inside : side.outside) = true;
        }
    };
    for (std::size_t i = formula.instructions.size(); i-- > 0;) {
        if (wanted[i].inside) spread(formula.instructions[i], true);
        if (wanted[i].outside) spread(formula.instructions[i], false);
    }
    return sides;
}

FormulaState::FormulaState(const BooleanFormula& formula, std::int32_t n_operands)
    : uses_of_operand_(n_operands),
      uses_of_instruction_(formula.instructions.size()),
      n_true_(formula.instructions.size(), 0),
      n_needed_(formula.instructions.size()),
      values_(formula.instructions.size(), 0)
{
    for (std::size_t i = 0; i < formula.instructions.size(); ++i) {
        const auto& instruction = formula.instructions[i];
        n_needed_[i] =
            instruction.is_intersection ? static_cast<std::int32_t>(instruction.terms.size()) : 1;
        for (const auto& term : instruction.terms) {
            auto& uses = term.is_operand ? uses_of_operand_ : uses_of_instruction_;
            uses[term.index].push_back({static_cast<std::int32_t>(i), term.negated});
            const bool value = !term.is_operand && values_[term.index];
            n_true_[i] += value != term.negated;
        }
        values_[i] = n_true_[i] >= n_needed_[i];
    }
}

void FormulaState::set(std::int32_t operand, bool value)
{
    spread(uses_of_operand_[operand], value);
}

void FormulaState::spread(const std::vector<Use>& uses, bool value)
{
    // Changes wait here until they are told on. One that is taken back later is told both ways.
    std::vector<std::pair<std::int32_t, bool>> changed;
    const auto tell = [&](const std::vector<Use>& to, bool now) {
        for (const Use& use : to) {
            const std::int32_t i = use.instruction;
            n_true_[i] += now != use.negated ? 1 : -1;
            const bool holds = n_true_[i] >= n_needed_[i];
            if (holds == static_cast<bool>(values_[i])) continue;
            values_[i] = holds;
            changed.push_back({i, holds});
        }
    };
    tell(uses, value);
    for (std::size_t next = 0; next < changed.size(); ++next) {
        const auto [instruction, now] = changed[next];
        tell(uses_of_instruction_[instruction], now);
    }
}

}  // namespace genus
