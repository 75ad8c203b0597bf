#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace genus::language {

/// Red, green, blue and alpha in [0, 1] of a CSS colour name in any case, or of #rgb, #rgba,
/// #rrggbb, #rrggbbaa. Nothing for other text.
std::optional<std::array<double, 4>> parse_color(std::string_view text);

}  // namespace genus::language
