#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "genus/language/diagnostics.h"
#include "genus/language/model_tree.h"
#include "genus/model/solid.h"
#include "genus/polygon/region.h"

namespace genus {

struct ModelOptions {
    /// Variables of the model replaced from outside: name and text of an expression, "10" or
    /// "\"left\"" or "[1, 2]".
    std::vector<std::pair<std::string, std::string>> defines;
    /// $tolerance of the whole model, above what it says itself: round shapes without $fn are
    /// exact.
    std::optional<double> tolerance;
    /// Folders to look for `include` and `use`, after the folder of the file that asks and before
    /// those that the environment variable OPENSCADPATH lists and OpenSCAD's own.
    std::vector<std::string> library_paths;
    /// The value of $preview.
    bool preview = false;
    /// Whether to make the solid. Without, models run whose geometry cannot be made yet.
    bool solid = true;
    /// Whether the model may be a plane shape, which `TextModel::region` then is.
    bool plane = false;
    /// Most memory that the values of the model may take at a time, bytes.
    std::size_t memory = std::size_t{1} << 30;
    /// Where given, gets the messages even if the call throws.
    std::vector<Message>* messages = nullptr;
};

struct TextModel {
    Solid solid;
    std::optional<Region> region;     // of a plane model, where the options allow that
    std::optional<double> tolerance;  // as the model or the options set it
    std::vector<Message> messages;    // in order
    ModelNode tree;
};

/// Runs the text model in the file `path`: the OpenSCAD language as of release 2021.01, with hex
/// numbers, `$tolerance`, and the modules torus, ellipsoid, cone, quadric, half_space, implicit.
///
/// Where it differs: unknown modules and missing files are errors, not warnings; a default value
/// is evaluated only where its argument is missing; rands() without a seed gives the same numbers
/// at each run.
///
/// Throws ModelError with the place of the mistake: in the syntax, an unknown module, a failed
/// assertion, a recursion without an end, a missing file, geometry that cannot be made yet, more
/// memory than allowed. Throws FileError if `path` itself cannot be read, InvalidInput for a
/// define that is no name, Cancelled.
TextModel read_model(const std::string& path, const ModelOptions& options = {});

/// The same from a text. `path` stands for it in messages; files are looked for from its folder.
TextModel read_model_text(const std::string& text, const std::string& path,
                          const ModelOptions& options = {});

}  // namespace genus
