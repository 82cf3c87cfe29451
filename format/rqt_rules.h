#pragma once

#include <vector>

#include "cairn/pack_reader.h"
#include "format/finding.h"

namespace cairn {

/// The rules of the rqt layer: each tile has its heights, all of a level have the same tolerance and number
/// of triangulations, and these are exactly those made anew from the heights, neighbours included. Decodes
/// each height tile twice. The findings come in the index's order. REQUIRES: threads >= 1.
void check_rqt_layer(const PackReader& pack, int threads, std::vector<Finding>& findings);

}  // namespace cairn
