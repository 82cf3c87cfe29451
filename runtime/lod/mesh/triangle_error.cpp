#include "runtime/lod/mesh/triangle_error.h"

#include "runtime/lod/mesh/triangle_bound.h"
#include "runtime/lod/mesh/triangle_parts.h"

namespace cairn {

bool TriangleError::exceeds(const TileSurface& surface, const SampleTriangle& triangle) const {
  const StoredError stored = stored_error_of(surface, triangle);
  const bool only_samples = surface.error_m <= 0;
  if (stored.span == 1 && only_samples) return false;
  const CornerSamples samples(view_, surface, triangle, stored);
  const TriangleBound bound(view_, surface, samples);
  if (bound.is_within() || bound.is_invisible()) return false;
  if (bound.assume_exceeds()) return true;
  if (stored.ranges != nullptr) return any_part_exceeds(view_, surface, samples);
  return !only_samples || stored.span > kMaxExactSpan ||
         any_sample_exceeds(view_, surface, samples, triangle);
}

}  // namespace cairn
