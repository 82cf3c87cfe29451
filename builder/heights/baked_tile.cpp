#include "builder/heights/baked_tile.h"

#include "format/height_block.h"

namespace cairn {

void append_baked_tile(const BakedTile& baked, std::vector<std::byte>& out) {
  ByteWriter writer(out);
  writer.write(std::int32_t{baked.id.level});
  writer.write(baked.id.x);
  writer.write(baked.id.y);
  writer.write(baked.filled);
  writer.write(std::uint8_t{baked.has_stored});
  writer.write(std::uint8_t{baked.lends_edge});
  writer.write(static_cast<std::uint32_t>(baked.errors_m.size()));
  for (const double error : baked.errors_m) writer.write(error);
  baked.settled.append_to(out);
  writer.write(static_cast<std::uint32_t>(baked.open.size()));
  for (const PostStats& stats : baked.open) stats.append_to(out);
  writer.write(static_cast<std::uint32_t>(baked.posts_won.size()));
  for (const std::uint64_t won : baked.posts_won) writer.write(won);
  const std::vector<std::byte> block = encode_height_block(baked.tile, default_height_codec());
  writer.write(static_cast<std::uint32_t>(block.size()));
  writer.append(block);
}

Result<BakedTile> read_baked_tile(ByteReader& in, int tile_size) {
  BakedTile baked;
  baked.id.level = in.read<std::int32_t>();
  baked.id.x = in.read<std::int32_t>();
  baked.id.y = in.read<std::int32_t>();
  baked.filled = in.read<double>();
  baked.has_stored = in.read<std::uint8_t>() != 0;
  baked.lends_edge = in.read<std::uint8_t>() != 0;
  for (auto n = in.read<std::uint32_t>(); n > 0 && in.ok(); --n) baked.errors_m.push_back(in.read<double>());
  baked.settled = PostStats::read_from(in);
  for (auto n = in.read<std::uint32_t>(); n > 0 && in.ok(); --n)
    baked.open.push_back(PostStats::read_from(in));
  for (auto n = in.read<std::uint32_t>(); n > 0 && in.ok(); --n)
    baked.posts_won.push_back(in.read<std::uint64_t>());
  const auto block = in.take(in.read<std::uint32_t>());
  if (!in.ok() || !is_valid(baked.id)) return bad_data("journal: a finished subtree: expected more bytes");
  auto tile = decode_height_block(block, tile_size);
  if (!tile) return tile.error();
  baked.tile = std::move(*tile);
  return baked;
}

}  // namespace cairn
