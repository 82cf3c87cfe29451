#pragma once

#include "builder/mosaic/sample_window.h"
#include "builder/mosaic/source_group.h"

namespace cairn {

/// The window of a coarser level, `levels` steps up, whose samples surround the given one's.
SampleWindow coarser_window(const SampleWindow& window, int levels);

/// Interpolates linearly from coarser_window(window, levels) to `window`; posts in the window move with it. A
/// sample that both have keeps its bits.
GroupSamples upsample(const GroupSamples& coarse, const SampleWindow& window, int levels);

}  // namespace cairn
