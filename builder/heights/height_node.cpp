#include "builder/heights/height_node.h"

#include <algorithm>

#include "format/height_block.h"

namespace cairn {
namespace {

constexpr std::uint32_t kMostSources = 1 << 24;

// Of thousands of sources a subtree has posts of a few: those are written, with their numbers.
void append_counts(const std::vector<std::uint64_t>& counts, ByteWriter& writer) {
  const auto zeros = std::count(counts.begin(), counts.end(), std::uint64_t{0});
  writer.write(static_cast<std::uint32_t>(counts.size()));
  writer.write(static_cast<std::uint32_t>(counts.size()) - static_cast<std::uint32_t>(zeros));
  for (std::size_t s = 0; s < counts.size(); ++s) {
    if (counts[s] == 0) continue;
    writer.write(static_cast<std::uint32_t>(s));
    writer.write(counts[s]);
  }
}

bool read_counts(ByteReader& in, std::vector<std::uint64_t>& counts) {
  const auto sources = in.read<std::uint32_t>();
  if (!in.ok() || sources > kMostSources) return false;
  counts.assign(sources, 0);
  for (auto n = in.read<std::uint32_t>(); n > 0 && in.ok(); --n) {
    const auto source = in.read<std::uint32_t>();
    if (source >= sources) return false;
    counts[source] = in.read<std::uint64_t>();
  }
  return in.ok();
}

}  // namespace

void append_height_node(const HeightNode& node, std::vector<std::byte>& out) {
  ByteWriter writer(out);
  writer.write(std::int32_t{node.id.level});
  writer.write(node.id.x);
  writer.write(node.id.y);
  writer.write(node.filled);
  writer.write(std::uint8_t{node.has_stored});
  writer.write(std::uint8_t{node.edge_only});
  writer.write(static_cast<std::uint32_t>(node.errors_m.size()));
  for (const double error : node.errors_m) writer.write(error);
  node.final_stats.append_to(out);
  writer.write(static_cast<std::uint32_t>(node.candidate_stats.size()));
  for (const ErrorStats& stats : node.candidate_stats) stats.append_to(out);
  append_counts(node.posts_used, writer);
  append_counts(node.posts_lost, writer);
  const std::vector<std::byte> block = encode_height_block(node.tile, default_height_codec());
  writer.write(static_cast<std::uint32_t>(block.size()));
  writer.append(block);
}

Result<HeightNode> read_height_node(ByteReader& in, int tile_size) {
  HeightNode node;
  node.id.level = in.read<std::int32_t>();
  node.id.x = in.read<std::int32_t>();
  node.id.y = in.read<std::int32_t>();
  node.filled = in.read<double>();
  node.has_stored = in.read<std::uint8_t>() != 0;
  node.edge_only = in.read<std::uint8_t>() != 0;
  for (auto n = in.read<std::uint32_t>(); n > 0 && in.ok(); --n) node.errors_m.push_back(in.read<double>());
  node.final_stats = ErrorStats::read_from(in);
  for (auto n = in.read<std::uint32_t>(); n > 0 && in.ok(); --n)
    node.candidate_stats.push_back(ErrorStats::read_from(in));
  const bool counts = read_counts(in, node.posts_used) && read_counts(in, node.posts_lost);
  const auto block = in.take(in.read<std::uint32_t>());
  if (!counts || !in.ok() || !is_valid(node.id))
    return bad_data("journal: a finished subtree: expected more bytes");
  auto tile = decode_height_block(block, tile_size);
  if (!tile) return tile.error();
  node.tile = std::move(*tile);
  return node;
}

}  // namespace cairn
