#pragma once

#include <string>
#include <vector>

#include "cairn/pack_reader.h"
#include "format/pack_verify.h"

namespace cairn {

/// Measures the pack against the DEMs that it was baked from: a finding where a post is further off than
/// promised, or where the measurement is not the one that the pack states. `inputs` as `cairn bake` takes
/// them; `geoid` may be empty.
Result<std::vector<Finding>> verify_against(const PackReader& pack, const std::vector<std::string>& inputs,
                                            const std::string& geoid, int threads);

}  // namespace cairn
