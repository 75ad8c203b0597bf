#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace genus::io {

/// The base64 code of [rfc4648], section 4.
std::string base64_encoded(std::span<const char> bytes);
/// Nothing where the text is not such a code; missing '=' at the end are forgiven.
std::optional<std::vector<std::byte>> base64_decoded(std::string_view text);

/// A web address with its %XX replaced by the bytes they stand for.
std::string percent_decoded(std::string_view uri);

}  // namespace genus::io
