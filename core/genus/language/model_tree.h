#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace genus {

/// A parameter of a node: undefined, a truth value, a number, a text, or a list of such.
struct ModelValue {
    using List = std::vector<ModelValue>;
    std::variant<std::monostate, bool, double, std::string, List> data;

    ModelValue() = default;
    ModelValue(bool b) : data(b) {}
    ModelValue(double n) : data(n) {}
    ModelValue(std::string s) : data(std::move(s)) {}
    ModelValue(List l) : data(std::move(l)) {}
    template <typename T>
    ModelValue(const T*) = delete;  // would be taken for a truth value

    bool is_undef() const { return data.index() == 0; }
    const double* number() const { return std::get_if<double>(&data); }
    const List* list() const { return std::get_if<List>(&data); }
    const std::string* text() const { return std::get_if<std::string>(&data); }
    /// False where it is no truth value.
    bool truth() const { return std::holds_alternative<bool>(data) && std::get<bool>(data); }
    bool operator==(const ModelValue&) const = default;
};

/// What a text model comes to once all its loops, calls and conditions are run: a tree of shapes
/// and of what is done to them, each with its evaluated parameters. The names are those of the
/// text language; modules of the model itself have become groups.
struct ModelNode {
    std::string name;
    /// In the order in which the text form shows them. The name is empty where it shows none.
    std::vector<std::pair<std::string, ModelValue>> parameters;
    std::vector<ModelNode> children;

    std::shared_ptr<const std::string> file;
    int line = 0;
    int column = 0;

    bool root = false;        // modifier !: only this one counts
    bool highlight = false;   // modifier #
    bool background = false;  // modifier %: not part of the result

    /// Of a round shape: sides of the polyhedron that stands for it, 0 for the exact shape.
    int fragments = 0;
    /// $tolerance where the node was made, 0 where there is none.
    double tolerance = 0.0;
    /// The file that the node names, as it can be opened.
    std::string path;

    ModelNode() = default;
    ModelNode(const ModelNode&) = default;
    ModelNode(ModelNode&&) noexcept = default;
    ModelNode& operator=(const ModelNode&) = default;
    ModelNode& operator=(ModelNode&&) noexcept = default;
    /// Deep trees are taken apart without recursion.
    ~ModelNode();

    /// Undefined where there is none of that name.
    const ModelValue& parameter(std::string_view parameter_name) const;
};

/// The tree as a flat text model of basic shapes, numbers to six digits.
std::string to_csg(const ModelNode& tree);

}  // namespace genus
