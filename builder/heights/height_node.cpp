#include "builder/heights/height_node.h"

#include "format/height_block.h"

namespace cairn {

void append_height_node(const HeightNode& baked, std::vector<std::byte>& out) {
  ByteWriter writer(out);
  writer.write(std::int32_t{baked.id.level});
  writer.write(baked.id.x);
  writer.write(baked.id.y);
  writer.write(baked.filled);
  writer.write(std::uint8_t{baked.has_stored});
  writer.write(std::uint8_t{baked.edge_only});
  writer.write(static_cast<std::uint32_t>(baked.errors_m.size()));
  for (const double error : baked.errors_m) writer.write(error);
  baked.settled.append_to(out);
  writer.write(static_cast<std::uint32_t>(baked.open.size()));
  for (const ErrorStats& stats : baked.open) stats.append_to(out);
  writer.write(static_cast<std::uint32_t>(baked.posts_used.size()));
  for (const std::uint64_t won : baked.posts_used) writer.write(won);
  const std::vector<std::byte> block = encode_height_block(baked.tile, default_height_codec());
  writer.write(static_cast<std::uint32_t>(block.size()));
  writer.append(block);
}

Result<HeightNode> read_height_node(ByteReader& in, int tile_size) {
  HeightNode baked;
  baked.id.level = in.read<std::int32_t>();
  baked.id.x = in.read<std::int32_t>();
  baked.id.y = in.read<std::int32_t>();
  baked.filled = in.read<double>();
  baked.has_stored = in.read<std::uint8_t>() != 0;
  baked.edge_only = in.read<std::uint8_t>() != 0;
  for (auto n = in.read<std::uint32_t>(); n > 0 && in.ok(); --n) baked.errors_m.push_back(in.read<double>());
  baked.settled = ErrorStats::read_from(in);
  for (auto n = in.read<std::uint32_t>(); n > 0 && in.ok(); --n)
    baked.open.push_back(ErrorStats::read_from(in));
  for (auto n = in.read<std::uint32_t>(); n > 0 && in.ok(); --n)
    baked.posts_used.push_back(in.read<std::uint64_t>());
  const auto block = in.take(in.read<std::uint32_t>());
  if (!in.ok() || !is_valid(baked.id)) return bad_data("journal: a finished subtree: expected more bytes");
  auto tile = decode_height_block(block, tile_size);
  if (!tile) return tile.error();
  baked.tile = std::move(*tile);
  return baked;
}

}  // namespace cairn
