#pragma once

// The rules that verify_pack() applies, one function each. Each adds a finding for what it sees broken, and
// none for what another rule reports.

#include <optional>
#include <vector>

#include "cairn/pack_reader.h"
#include "format/finding.h"
#include "format/tile_edges.h"

namespace cairn {

/// By index entry; empty for what is no height tile or does not decode.
using Digests = std::vector<std::optional<TileDigest>>;

/// The metadata is there and is UTF-8.
void check_metadata(const PackReader& pack, std::vector<Finding>& findings);

/// From the header to the index each byte belongs to one block, which several entries may share.
void check_coverage(const PackReader& pack, std::vector<Finding>& findings);

/// The entry's block has its checksum and decodes; minimum, maximum, constant and void flags are as the
/// samples have them; the overhang is void. Returns a height tile's digest.
std::optional<TileDigest> check_content(const PackReader& pack, const IndexEntry& entry,
                                        std::vector<Finding>& findings);

/// A tile below its layer's coarsest level has a parent, whose error is no smaller, and whose samples are its
/// own even ones.
void check_parent(const PackReader& pack, std::size_t index, const Digests& digests,
                  std::vector<Finding>& findings);

/// A height tile's eastern and northern edges and corners are those of its neighbours.
void check_neighbours(const PackReader& pack, std::size_t index, const Digests& digests,
                      std::vector<Finding>& findings);

}  // namespace cairn
