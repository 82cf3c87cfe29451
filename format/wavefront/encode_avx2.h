#pragma once

#include "format/wavefront/avx2.h"
#include "format/wavefront/coder.h"

#if defined(__x86_64__)

namespace cairn::wavefront {

/// find_residuals and encode_samples for CPUs with AVX2. REQUIRES: cpu_has_avx2().
Residuals find_residuals_avx2(const Geometry& g, const Plane& plane, const Weights& weights,
                              Histogram& histogram);
Streams encode_samples_avx2(const Geometry& g, const Model& model, const Residuals& residuals);

}  // namespace cairn::wavefront

#endif
