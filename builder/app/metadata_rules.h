#pragma once

#include <vector>

#include "cairn/pack_reader.h"
#include "format/pack_verify.h"

namespace cairn {

/// Checks that the metadata JSON has the keys that docs/pack-format.md promises, of the right types, and that
/// its numbers agree with the header and the index. A finding a rule that is broken.
std::vector<Finding> check_metadata_json(const PackReader& pack);

}  // namespace cairn
