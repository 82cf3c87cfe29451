#pragma once

// The rules that verify_pack() applies, one function each. A rule adds a finding for each violation of its
// own, and none for what another rule reports.

#include <optional>
#include <vector>

#include "cairn/pack_reader.h"
#include "format/finding.h"
#include "format/tile_edges.h"

namespace cairn {

/// By index entry; nullopt for what is no height tile or does not decode.
using Digests = std::vector<std::optional<TileDigest>>;

/// Rule: the metadata exists and is UTF-8.
void check_metadata(const PackReader& pack, std::vector<Finding>& findings);

/// Rule: from the header to the index each byte belongs to one block, which several entries may share.
void check_coverage(const PackReader& pack, std::vector<Finding>& findings);

/// Rule: the entry's block has its checksum and decodes; minimum, maximum, constant and void flags agree with
/// the samples; the overhang is void. Returns a height tile's digest.
std::optional<TileDigest> check_content(const PackReader& pack, const IndexEntry& entry,
                                        std::vector<Finding>& findings);

/// Rule: a tile finer than its layer's coarsest level has a parent, whose error is no smaller, and whose
/// samples are its own even ones.
void check_parent(const PackReader& pack, std::size_t index, const Digests& digests,
                  std::vector<Finding>& findings);

/// Rule: a height tile's eastern and northern edges and corners are those of its neighbours.
void check_neighbours(const PackReader& pack, std::size_t index, const Digests& digests,
                      std::vector<Finding>& findings);

}  // namespace cairn
