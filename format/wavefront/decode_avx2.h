#pragma once

#include "format/wavefront/avx2.h"
#include "format/wavefront/coder.h"

#if defined(CAIRN_AVX2_DECODER)

namespace cairn::wavefront {

/// decode_samples for CPUs with AVX2. REQUIRES: cpu_has_avx2().
bool decode_samples_avx2(const Geometry& g, const Model& model, const CodedSamples& coded, std::int32_t base,
                         std::span<std::int32_t> samples);

}  // namespace cairn::wavefront

#endif
