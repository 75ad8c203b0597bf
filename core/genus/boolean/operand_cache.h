#pragma once

#include <list>
#include <memory>
#include <mutex>

#include "genus/boolean/mesh_boolean.h"

namespace genus {

/// Operands by the identity of their mesh, so that a mesh that comes up again is known. Meshes are
/// not kept alive; what is known of those that are gone, and of the longest unused ones beyond the
/// given number of faces in all, is forgotten. Safe to use from many threads.
class OperandCache {
public:
    /// 16 bytes a face are kept at most.
    explicit OperandCache(std::size_t most_faces = 8'000'000) : most_faces_(most_faces) {}

    /// To be used while the caller keeps the mesh. `clean` as of a result. O(operands kept).
    BooleanOperand find(const std::shared_ptr<const IndexedMesh>& mesh, bool clean = false);

    /// Operands kept at present.
    std::size_t size() const;

private:
    struct Entry {
        std::weak_ptr<const IndexedMesh> mesh;
        BooleanOperand operand;
        std::size_t n_faces;
    };
    void forget();

    std::size_t most_faces_;
    mutable std::mutex mutex_;
    std::list<Entry> entries_;  // the last used first
};

}  // namespace genus
