#pragma once

#include "genus/model/solid.h"
#include "genus/patch/patch_model.h"

namespace genus {

/// The solid inside patches that form closed surfaces; what several of them hold is united. It is
/// tessellated when meshed, to the tolerance asked for, with a proven bound.
/// Throws InvalidInput unless every edge belongs to two patches that run along it in opposite
/// directions; the text tells which does not.
Solid patch_solid(const PatchModel& model);

}  // namespace genus
