#pragma once

#include <array>
#include <cmath>
#include <string>

#include "genus/base/error.h"
#include "genus/base/vec.h"
#include "genus/language/facets.h"
#include "genus/language/model_tree.h"

namespace genus::language {

/// Reads the parameters of a node as numbers and vectors; what is none is a ModelError at its
/// place that names node and parameter.
class NodeReader {
public:
    explicit NodeReader(const ModelNode& node) : node_(node) {}

    [[noreturn]] void fail(const std::string& problem) const
    {
        throw ModelError(*node_.file, node_.line, node_.column, problem);
    }

    double number(const char* name) const
    {
        const double* n = node_.parameter(name).number();
        if (!n) fail(node_.name + "(): " + name + " is no number");
        return *n;
    }
    bool has(const char* name) const { return !node_.parameter(name).is_undef(); }
    bool truth(const char* name) const { return node_.parameter(name).truth(); }

    const ModelValue::List& rows(const char* name) const
    {
        const ModelValue::List* list = node_.parameter(name).list();
        if (!list) fail(node_.name + "(): " + name + " is no vector");
        return *list;
    }

    template <std::size_t n>
    std::array<double, n> numbers(const ModelValue& v, const std::string& name,
                                  bool finite = true) const
    {
        const ModelValue::List* list = v.list();
        std::array<double, n> out;
        bool good = list && list->size() == n;
        for (std::size_t i = 0; good && i < n; ++i) {
            const double* x = (*list)[i].number();
            good = x && (!finite || std::isfinite(*x));
            if (good) out[i] = *x;
        }
        if (!good)
            fail(node_.name + "(): " + name + " is no vector of " + std::to_string(n) +
                 " finite numbers");
        return out;
    }
    template <std::size_t n>
    Vec<n> vec(const ModelValue& v, const std::string& name) const
    {
        return {numbers<n>(v, name)};
    }
    Vec2 vec2(const char* name) const { return vec<2>(node_.parameter(name), name); }
    Vec3 vec3(const char* name) const { return vec<3>(node_.parameter(name), name); }

    /// The number of one of `n_points` points.
    std::int32_t point_number(const ModelValue& v, std::size_t n_points,
                              const std::string& of) const
    {
        const double* n = v.number();
        if (!n || !(*n > -1.0) || !(*n < static_cast<double>(n_points)))
            fail(node_.name + "(): " + of + " names a point that is not among the " +
                 std::to_string(n_points));
        return static_cast<std::int32_t>(*n);
    }

    /// The special variables that the node was made under.
    Facets facets() const
    {
        const auto get = [&](const char* name, double otherwise) {
            const double* n = node_.parameter(name).number();
            return n ? *n : otherwise;
        };
        return {get("$fn", 0.0), get("$fa", 12.0), get("$fs", 2.0), node_.tolerance};
    }

protected:
    const ModelNode& node_;
};

}  // namespace genus::language
