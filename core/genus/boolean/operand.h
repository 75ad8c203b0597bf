#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "genus/boolean/closed_operand.h"
#include "genus/boolean/frame.h"
#include "genus/boolean/mesh_boolean.h"

namespace genus {

/// What booleans found out about a mesh. At most 16 bytes a face of it, and few grids.
struct BooleanOperand::Known {
    std::shared_ptr<const IndexedMesh> mesh;

    std::mutex mutex;  // of all that follows
    std::shared_ptr<const exact::ClosedOperand> closed;
    bool clean = false;                  // as it is, it does not cross or touch itself
    std::vector<exact::Frame> clean_on;  // nor with its corners rounded to these grids
};

}  // namespace genus
