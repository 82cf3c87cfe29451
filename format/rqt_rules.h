#pragma once

#include <vector>

#include "cairn/pack_reader.h"
#include "format/finding.h"

namespace cairn {

/// Checks the rqt layer: each tile has its heights, tiles of a level have one tolerance and number of
/// triangulations, and these are exactly those worked out anew from the heights, neighbours included. Decodes
/// each height tile twice. Findings are in the index's order. REQUIRES: threads >= 1.
void check_rqt_layer(const PackReader& pack, int threads, std::vector<Finding>& findings);

}  // namespace cairn
