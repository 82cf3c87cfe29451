#pragma once

// The rules of verify_pack() about objects and their models.

#include <vector>

#include "cairn/pack_reader.h"
#include "format/finding.h"

namespace cairn {

/// Rule: a tile of objects decodes; its entry counts them, and none is larger than it says; the pack has each
/// one's model; each belongs to the tile's level by its size; there is ground beneath each, and the lowest
/// and the highest foot are as they are measured on it again.
void check_object_tile(const PackReader& pack, const IndexEntry& entry, std::vector<Finding>& findings);

/// Rule: models are numbered from 0 without a gap; each decodes, and its entry says its triangles and size.
void check_model(const PackReader& pack, const IndexEntry& entry, std::vector<Finding>& findings);

}  // namespace cairn
