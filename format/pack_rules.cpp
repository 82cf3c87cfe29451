#include "format/pack_rules.h"

#include <algorithm>
#include <compare>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "cairn/texture_tile.h"
#include "format/height_block.h"
#include "format/index_entry.h"

namespace cairn {
namespace {

std::string name_of(const IndexEntry& entry) {
  return std::string(to_string(entry.layer)) + " " + to_string(entry.id);
}

std::string expected(const std::string& what, const std::string& wanted, const std::string& found) {
  return what + ": expected " + wanted + ", found " + found;
}

/// Length of the UTF-8 sequence that starts at `text`, 0 where there is none (Unicode 15, table 3-7).
std::size_t utf8_sequence(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return 1;
  const std::size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < length) return 0;
  const unsigned char low = lead == 0xE0 ? 0xA0 : lead == 0xF0 ? 0x90 : 0x80;
  const unsigned char high = lead == 0xED ? 0x9F : lead == 0xF4 ? 0x8F : 0xBF;
  if (byte(1) < low || byte(1) > high) return 0;
  for (std::size_t i = 2; i < length; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return 0;
  }
  return length;
}

void check_range_and_flags(const IndexEntry& entry, const HeightTile& tile, std::vector<Finding>& findings) {
  const HeightRange range = range_of(tile);
  const auto add = [&](std::string what) { findings.push_back({name_of(entry), std::move(what)}); };
  if (entry.min_quanta != range.lowest) {
    add(expected("minimum", std::to_string(range.lowest) + " as the samples have",
                 std::to_string(entry.min_quanta)));
  }
  if (entry.max_quanta != range.highest) {
    add(expected("maximum", std::to_string(range.highest) + " as the samples have",
                 std::to_string(entry.max_quanta)));
  }
  const bool has_voids = !tile.voids.empty();
  if (has_voids != ((entry.flags & kHasVoids) != 0)) {
    add(expected("void flag", has_voids ? "1 as the block has a mask" : "0 as the block has no mask",
                 has_voids ? "0" : "1"));
  }
  if (!has_voids && range.lowest == range.highest && (entry.flags & kConstant) == 0) {
    add("expected a constant tile without a block, found a block of equal samples");
  }
}

void check_overhang(const IndexEntry& entry, const HeightTile& tile, std::vector<Finding>& findings) {
  const WorldExtent inside = world_extent(entry.id, tile.size);
  for (int row = 0; row < tile.size; ++row) {
    for (int column = row > inside.north ? 0 : inside.east + 1; column < tile.size; ++column) {
      if (tile.is_void(column, row)) continue;
      findings.push_back({name_of(entry), "sample " + std::to_string(column) + "," + std::to_string(row) +
                                              ": expected a void past the world's edge, found a height"});
      return;
    }
  }
}

void check_other_content(const PackReader& pack, const IndexEntry& entry, std::vector<Finding>& findings) {
  const Result<std::vector<std::byte>> block = pack.read_block(entry);
  if (!block) {
    findings.push_back(finding_from(pack, entry, block.error()));
  } else if (entry.layer == Layer::imagery && entry.bytes != 0) {
    const Result<TextureTile> tile = decode_texture_block(*block, pack.header().tile_size - 1);
    if (!tile) findings.push_back(finding_from(pack, entry, tile.error()));
  }
}

std::string sample_text(std::int64_t sample) {
  return sample == kVoidSample ? "a void" : std::to_string(sample);
}

/// How many of two tiles' common samples differ, and the first that does.
std::string difference(const std::vector<std::int64_t>& mine, const std::vector<std::int64_t>& other) {
  std::size_t count = 0;
  std::size_t first = 0;
  for (std::size_t i = mine.size(); i-- > 0;) {
    if (mine[i] == other[i]) continue;
    ++count;
    first = i;
  }
  return std::to_string(count) + " of " + std::to_string(mine.size()) +
         " samples differ, the first is number " + std::to_string(first) + ": " + sample_text(mine[first]) +
         " here, " + sample_text(other[first]) + " there";
}

void check_nesting(const PackReader& pack, const IndexEntry& child, const IndexEntry& parent,
                   std::vector<Finding>& findings) {
  const Result<HeightTile> mine = pack.read_height_tile(child);
  const Result<HeightTile> above = pack.read_height_tile(parent);
  if (!mine || !above) return;
  findings.push_back(
      {name_of(child), "expected every second sample in its parent " + to_string(parent.id) + "; " +
                           difference(even_samples(*mine), quadrant_samples(*above, quadrant_of(child.id)))});
}

void report_edge(const PackReader& pack, const IndexEntry& tile, const IndexEntry& neighbour, Edge edge,
                 std::vector<Finding>& findings) {
  const Result<HeightTile> mine = pack.read_height_tile(tile);
  const Result<HeightTile> other = pack.read_height_tile(neighbour);
  if (!mine || !other) return;
  const bool east = edge == Edge::east;
  findings.push_back(
      {name_of(tile), std::string("expected its ") + (east ? "eastern" : "northern") +
                          " edge in its neighbour " + to_string(neighbour.id) + "; " +
                          difference(edge_samples(*mine, tile.id, edge),
                                     edge_samples(*other, neighbour.id, east ? Edge::west : Edge::south))});
}

void report_corner(const IndexEntry& tile, const TileId& neighbour, const char* corner, std::int64_t mine,
                   std::int64_t other, std::vector<Finding>& findings) {
  findings.push_back({name_of(tile), std::string("expected its ") + corner + " corner in its neighbour " +
                                         to_string(neighbour) + "; " + sample_text(mine) + " here, " +
                                         sample_text(other) + " there"});
}

/// Each byte of [start, end) is in one of the ranges, which ascend.
void check_each_byte_once(const char* where, const std::string& part, std::span<const ByteRange> ranges,
                          std::uint64_t start, std::uint64_t end, std::vector<Finding>& findings) {
  std::uint64_t at = start;
  const auto compare = [&](std::uint64_t offset) {
    if (offset == at) return;
    findings.push_back(
        {where, expected("byte " + std::to_string(std::min(at, offset)), "each byte in one " + part,
                         offset > at ? "bytes in none" : part + "s that overlap")});
  };
  for (const ByteRange& range : ranges) {
    compare(range.offset);
    at = std::max(at, range.offset + range.bytes);
  }
  compare(end);
}

}  // namespace

Finding finding_from(const PackReader& pack, const IndexEntry& entry, const Error& error) {
  const std::string prefixes[] = {pack.path().string() + ": ", std::string(to_string(entry.layer)) +
                                                                   " tile " + to_string(entry.id) + ": "};
  std::string what = error.message;
  for (const std::string& prefix : prefixes) {
    if (what.starts_with(prefix)) what.erase(0, prefix.size());
  }
  return {name_of(entry), what};
}

void check_metadata(const PackReader& pack, std::vector<Finding>& findings) {
  const std::string_view text = pack.metadata_json();
  if (text.empty()) findings.push_back({"metadata", "expected JSON, found nothing"});
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8_sequence(text.substr(at));
    if (length == 0) {
      findings.push_back({"metadata", "expected UTF-8, found another byte at " + std::to_string(at)});
      return;
    }
    at += length;
  }
}

void check_pages(const PackReader& pack, std::vector<ByteRange> pages, std::vector<Finding>& findings) {
  std::sort(pages.begin(), pages.end(),
            [](const ByteRange& a, const ByteRange& b) { return a.offset < b.offset; });
  check_each_byte_once("index", "page", pages, pack.header().index_offset, pack.header().metadata_offset,
                       findings);
}

void check_coverage(const PackReader& pack, std::vector<Finding>& findings) {
  struct Block {
    std::uint64_t offset;
    std::uint64_t bytes;
    bool is_shared;
    auto operator<=>(const Block&) const = default;
  };
  std::vector<Block> blocks;
  for (std::size_t i = 0; i < pack.entry_count(); ++i) {
    const IndexEntry entry = pack.entry(i);
    if (entry.bytes != 0) blocks.push_back({entry.offset, entry.bytes, (entry.flags & kSharedBlock) != 0});
  }
  std::sort(blocks.begin(), blocks.end());
  std::vector<ByteRange> once;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const bool is_first =
        i == 0 || blocks[i].offset != blocks[i - 1].offset || blocks[i].bytes != blocks[i - 1].bytes;
    if (is_first) once.push_back({blocks[i].offset, blocks[i].bytes});
    if (is_first == blocks[i].is_shared) {
      findings.push_back({"blocks", expected("block at byte " + std::to_string(blocks[i].offset),
                                             "one tile that does not share it", is_first ? "none" : "two")});
    }
  }
  check_each_byte_once("blocks", "block", once, kPackStartBytes, pack.header().index_offset, findings);
}

void check_level_table(const PackReader& pack, std::vector<Finding>& findings) {
  std::vector<PackLevel> levels;
  for (std::size_t i = 0; i < pack.entry_count(); ++i) {
    const IndexEntry entry = pack.entry(i);
    if (levels.empty() || levels.back().layer != entry.layer || levels.back().level != entry.id.level)
      levels.push_back({entry.layer, entry.id.level});
    add_to_level(entry, levels.back());
  }
  const std::span<const PackLevel> stated = pack.level_table();
  for (std::size_t i = 0; i < std::max(levels.size(), stated.size()); ++i) {
    const bool agree = i < levels.size() && i < stated.size() && levels[i] == stated[i];
    if (agree) continue;
    const PackLevel& level = i < stated.size() ? stated[i] : levels[i];
    findings.push_back({"root", "expected the sums of the entries for " +
                                    std::string(to_string(level.layer)) + " level " +
                                    std::to_string(level.level) + ", found others"});
    return;
  }
}

std::optional<TileDigest> check_content(const PackReader& pack, const IndexEntry& entry,
                                        std::vector<Finding>& findings) {
  if (entry.layer != Layer::heights) {
    check_other_content(pack, entry, findings);
    return std::nullopt;
  }
  const Result<HeightTile> tile = pack.read_height_tile(entry);
  if (!tile) {
    findings.push_back(finding_from(pack, entry, tile.error()));
    return std::nullopt;
  }
  check_range_and_flags(entry, *tile, findings);
  check_overhang(entry, *tile, findings);
  return digest_of(*tile, entry.id);
}

void check_parent(const PackReader& pack, std::size_t index, const Digests& digests,
                  std::vector<Finding>& findings) {
  const IndexEntry entry = pack.entry(index);
  if (entry.id.level == pack.levels(entry.layer)->coarsest) return;
  const TileId parent_id = parent_of(entry.id);
  const std::optional<std::size_t> parent_index = pack.find_index(entry.layer, parent_id);
  if (!parent_index) {
    findings.push_back({name_of(entry), "expected its parent " + to_string(parent_id) + ", found none"});
    return;
  }
  const IndexEntry parent = pack.entry(*parent_index);
  if (parent.geometric_error_m < entry.geometric_error_m) {
    findings.push_back({name_of(entry), expected("geometric error",
                                                 "no more than its parent's " +
                                                     std::to_string(parent.geometric_error_m) + " m",
                                                 std::to_string(entry.geometric_error_m) + " m")});
  }
  const auto& mine = digests[index];
  const auto& above = digests[*parent_index];
  if (!mine || !above) return;
  if (mine->even != above->quadrants[static_cast<std::size_t>(quadrant_of(entry.id))]) {
    check_nesting(pack, entry, parent, findings);
  }
}

void check_neighbours(const PackReader& pack, std::size_t index, const Digests& digests,
                      std::vector<Finding>& findings) {
  const auto& mine = digests[index];
  if (!mine) return;
  const IndexEntry entry = pack.entry(index);
  const auto with = [&](std::int32_t dx, std::int32_t dy, auto&& compare) {
    const auto at = pack.find_index(Layer::heights, neighbour_of(entry.id, dx, dy));
    if (at && digests[*at]) compare(pack.entry(*at), *digests[*at]);
  };
  with(1, 0, [&](const IndexEntry& neighbour, const TileDigest& other) {
    if (mine->east != other.west) report_edge(pack, entry, neighbour, Edge::east, findings);
  });
  with(0, 1, [&](const IndexEntry& neighbour, const TileDigest& other) {
    if (mine->north != other.south) report_edge(pack, entry, neighbour, Edge::north, findings);
  });
  with(1, 1, [&](const IndexEntry& neighbour, const TileDigest& other) {
    if (mine->north_east == other.south_west) return;
    report_corner(entry, neighbour.id, "north-eastern", mine->north_east, other.south_west, findings);
  });
  with(1, -1, [&](const IndexEntry& neighbour, const TileDigest& other) {
    if (mine->south_east == other.north_west) return;
    report_corner(entry, neighbour.id, "south-eastern", mine->south_east, other.north_west, findings);
  });
}

}  // namespace cairn
