#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "genus/language/syntax.h"
#include "genus/language/value.h"

namespace genus::language {

class Evaluator;
struct ModuleArguments;

/// A function of the language itself, on evaluated arguments.
using BuiltinFunction = Value (*)(Evaluator&, const Call&, std::span<const Value> arguments);

/// Number of the function of that name, none if there is none.
std::optional<std::uint32_t> find_builtin_function(std::string_view name);
BuiltinFunction builtin_function(std::uint32_t number);
/// The number of `is_undef`, whose argument may be an unknown variable.
std::uint32_t is_undef_number();

/// Modules that the evaluator itself must know; all others only make a node of their arguments.
enum class BuiltinModule : std::uint32_t {
    For,
    IntersectionFor,
    Let,
    Assign,
    Echo,
    Assert,
    Children,
    Child,
    Group,
    First  // First: see below
};

/// Number of the module of that name: one of BuiltinModule, or First plus the number of a maker of
/// nodes.
std::optional<std::uint32_t> find_builtin_module(std::string_view name);

}  // namespace genus::language
