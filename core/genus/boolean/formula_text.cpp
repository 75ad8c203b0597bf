#include "genus/boolean/formula_text.h"

#include <charconv>
#include <unordered_map>
#include <utility>

#include "genus/base/error.h"

namespace genus {

namespace {

using Term = BooleanFormula::Term;

constexpr int kDeepest = 200;

bool is_word_character(char c)
{
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

class FormulaParser {
public:
    FormulaParser(std::string_view text, std::span<const std::string> names,
                  std::int32_t n_operands)
        : text_(text), n_operands_(n_operands)
    {
        for (std::size_t i = 0; i < names.size(); ++i)
            numbers_.emplace(names[i], static_cast<std::int32_t>(i));
    }

    BooleanFormula run()
    {
        const Term top = either();
        if (at_ < text_.size()) fail("an operator is missing");
        const auto last = static_cast<std::int32_t>(formula_.instructions.size()) - 1;
        if (top.is_operand || top.negated || top.index != last) formula_.add(false, {top});
        return std::move(formula_);
    }

private:
    [[noreturn]] void fail(const std::string& problem) const
    {
        throw InvalidInput("boolean: formula, character " + std::to_string(at_ + 1) + ": " +
                           problem);
    }

    void skip_space()
    {
        while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t' ||
                                      text_[at_] == '\n' || text_[at_] == '\r'))
            ++at_;
    }
    bool take(char c)
    {
        skip_space();
        if (at_ == text_.size() || text_[at_] != c) return false;
        ++at_;
        return true;
    }

    Term made(bool is_intersection, std::vector<Term> terms)
    {
        if (terms.size() == 1) return terms[0];
        return {formula_.add(is_intersection, std::move(terms)), false, false};
    }
    static Term negated(Term term)
    {
        term.negated = !term.negated;
        return term;
    }

    Term either()
    {
        std::vector<Term> terms{one_of_two()};
        while (take('|')) terms.push_back(one_of_two());
        return made(false, std::move(terms));
    }

    // (x | y) & ~(x & y)
    Term one_of_two()
    {
        Term left = both();
        while (take('^')) {
            const Term right = both();
            const Term any = made(false, {left, right}), all = made(true, {left, right});
            left = made(true, {any, negated(all)});
        }
        return left;
    }

    Term both()
    {
        std::vector<Term> terms{sum()};
        while (take('&')) terms.push_back(sum());
        return made(true, std::move(terms));
    }

    // x + y + z is one union, x - y - z one intersection of x, ~y and ~z.
    Term sum()
    {
        std::vector<Term> terms{part()};
        bool subtracts = false;
        while (true) {
            const bool plus = take('+');
            if (!plus && !take('-')) return made(subtracts, std::move(terms));
            if (terms.size() > 1 && subtracts == plus) terms = {made(subtracts, std::move(terms))};
            subtracts = !plus;
            terms.push_back(plus ? part() : negated(part()));
        }
    }

    Term part()
    {
        if (++depth_ > kDeepest) fail("nested more than 200 levels deep");
        Term result{};
        if (take('~')) {
            result = negated(part());
        } else if (take('(')) {
            result = either();
            if (!take(')')) fail("a closing parenthesis is missing");
        } else {
            result = {operand(), true, false};
        }
        --depth_;
        skip_space();
        return result;
    }

    std::int32_t operand()
    {
        const std::size_t start = at_;
        while (at_ < text_.size() && is_word_character(text_[at_])) ++at_;
        const std::string_view word = text_.substr(start, at_ - start);
        at_ = word.empty() ? at_ : start;  // where messages point
        if (word.empty()) fail("an operand is missing");
        std::int32_t number = -1;
        if (const auto named = numbers_.find(word); named != numbers_.end()) {
            number = named->second;
        } else {
            const auto [end, error] =
                std::from_chars(word.data(), word.data() + word.size(), number);
            if (error != std::errc() || end != word.data() + word.size())
                fail("'" + std::string(word.substr(0, 40)) + "' is no operand");
        }
        if (number < 0 || number >= n_operands_)
            fail("there is no operand " + std::string(word.substr(0, 40)) + " among the " +
                 std::to_string(n_operands_));
        at_ = start + word.size();
        return number;
    }

    std::string_view text_;
    std::int32_t n_operands_;
    std::unordered_map<std::string_view, std::int32_t> numbers_;
    std::size_t at_ = 0;
    int depth_ = 0;
    BooleanFormula formula_;
};

}  // namespace

BooleanFormula parse_formula(std::string_view text, std::span<const std::string> names,
                             std::int32_t n_operands)
{
    return FormulaParser(text, names, n_operands).run();
}

}  // namespace genus
