#pragma once

#include "isolux/bench/own_renderer.h"

/// The head phantom with `size` voxels along each side, its bone at 1024x1024, drawn once. Kept for
/// the kernels that follow.
isolux::OwnRenderer& head_of(int size);
