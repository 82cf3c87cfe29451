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

/// Returns an error of reading a tile as a finding. Takes the file's name off it, as a finding is about one
/// file.
Finding finding_from(const PackReader& pack, const IndexEntry& entry, const Error& error);

/// Rule: the metadata exists and is UTF-8.
void check_metadata(const PackReader& pack, std::vector<Finding>& findings);

/// Rule: each byte between the blocks and the metadata is in one page of the index.
void check_pages(const PackReader& pack, std::vector<ByteRange> pages, std::vector<Finding>& findings);

/// Rule: each byte between root and index is in one block. Of the entries that share a block, one is its
/// first.
void check_coverage(const PackReader& pack, std::vector<Finding>& findings);

/// Rule: the root's sums over each level are those of the entries.
void check_level_table(const PackReader& pack, std::vector<Finding>& findings);

/// Rule, but for objects and models: the entry's block has its checksum and decodes; minimum, maximum,
/// constant and void flags agree with the samples; the overhang is void. Returns a height tile's digest.
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
