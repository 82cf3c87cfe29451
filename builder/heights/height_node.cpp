#include "builder/heights/height_node.h"

#include "format/height_block.h"

namespace cairn {

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
  writer.write(static_cast<std::uint32_t>(node.posts_used.size()));
  for (const std::uint64_t won : node.posts_used) writer.write(won);
  writer.write(static_cast<std::uint32_t>(node.posts_lost.size()));
  for (const std::uint64_t lost : node.posts_lost) writer.write(lost);
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
  for (auto n = in.read<std::uint32_t>(); n > 0 && in.ok(); --n)
    node.posts_used.push_back(in.read<std::uint64_t>());
  for (auto n = in.read<std::uint32_t>(); n > 0 && in.ok(); --n)
    node.posts_lost.push_back(in.read<std::uint64_t>());
  const auto block = in.take(in.read<std::uint32_t>());
  if (!in.ok() || !is_valid(node.id)) return bad_data("journal: a finished subtree: expected more bytes");
  auto tile = decode_height_block(block, tile_size);
  if (!tile) return tile.error();
  node.tile = std::move(*tile);
  return node;
}

}  // namespace cairn
