#pragma once

#include <compare>
#include <cstdint>

namespace genus {

/// A number that says what it numbers. The default one is none.
template <class Tag>
struct Handle {
    std::int32_t index = -1;

    constexpr Handle() = default;
    constexpr explicit Handle(std::int32_t i) : index(i) {}
    constexpr explicit Handle(std::size_t i) : index(static_cast<std::int32_t>(i)) {}

    constexpr bool valid() const { return index >= 0; }
    constexpr auto operator<=>(const Handle&) const = default;
};

using Vertex = Handle<struct VertexTag>;
using Halfedge = Handle<struct HalfedgeTag>;
using Edge = Handle<struct EdgeTag>;
using Face = Handle<struct FaceTag>;
using Loop = Handle<struct LoopTag>;

}  // namespace genus
