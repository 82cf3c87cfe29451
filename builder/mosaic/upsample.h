#pragma once

#include "builder/mosaic/overlaid_samples.h"

namespace cairn {

/// The samples of a level so many levels coarser that those of the window lie between.
SampleWindow coarser_window(const SampleWindow& window, int levels);

/// Samples of coarser_window() as those of the window: heights and weights are interpolated linearly, the
/// state is the worst of the samples around, posts keep their places.
GroupSamples upsample(const GroupSamples& coarse, const SampleWindow& window, int levels);

/// The same for samples of a window `from` that holds those of coarser_window().
OverlaidSamples upsample(const OverlaidSamples& coarse, const SampleWindow& from, const SampleWindow& window,
                         int levels);

/// The part of a window's samples that lies in a smaller one.
OverlaidSamples cut(const OverlaidSamples& samples, const SampleWindow& from, const SampleWindow& window);

/// The posts of a window `from` that lie in the closed window so many levels finer.
MeasuredPosts posts_in(const MeasuredPosts& posts, const SampleWindow& from, const SampleWindow& to,
                       int levels);

}  // namespace cairn
