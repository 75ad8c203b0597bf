#include "genus/boolean/operand_cache.h"

#include <algorithm>

namespace genus {

BooleanOperand OperandCache::find(const std::shared_ptr<const IndexedMesh>& mesh, bool clean)
{
    const std::lock_guard lock(mutex_);
    // Owners are compared, not addresses, which come up again.
    const auto is_it = [&](const Entry& entry) {
        return !entry.mesh.owner_before(mesh) && !mesh.owner_before(entry.mesh);
    };
    const auto found = std::find_if(entries_.begin(), entries_.end(), is_it);
    if (found != entries_.end()) {
        entries_.splice(entries_.begin(), entries_, found);
    } else {
        const std::shared_ptr<const IndexedMesh> not_kept(std::shared_ptr<void>(), mesh.get());
        entries_.push_front({mesh, BooleanOperand(not_kept, clean), mesh->faces.size()});
    }
    const BooleanOperand operand = entries_.front().operand;
    forget();
    return operand;
}

std::size_t OperandCache::size() const
{
    const std::lock_guard lock(mutex_);
    return entries_.size();
}

void OperandCache::forget()
{
    entries_.remove_if([](const Entry& entry) { return entry.mesh.expired(); });
    std::size_t n_faces = 0;
    for (auto it = entries_.begin(); it != entries_.end();) {
        n_faces += it->n_faces;
        it = n_faces > most_faces_ ? entries_.erase(it) : std::next(it);
    }
}

}  // namespace genus
