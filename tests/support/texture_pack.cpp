#include "tests/support/texture_pack.h"

#include <cmath>
#include <cstdlib>

#include "builder/export/texture_file.h"
#include "format/block_texture.h"

namespace cairn::test {
namespace {

PackReader open_or_abort(const std::filesystem::path& path) {
  auto pack = PackReader::open(path);
  if (!pack) std::abort();
  return std::move(*pack);
}

struct Mean {
  double sum = 0;
  std::size_t count = 0;
  void add(const std::uint8_t* a, const std::uint8_t* b) {
    if (a[3] != 255 || b[3] != 255) return;
    for (int k = 0; k < 3; ++k) sum += std::abs(a[k] - b[k]);
    count += 3;
  }
  double value() const { return count > 0 ? sum / static_cast<double>(count) : 0; }
};

}  // namespace

TexturePack::TexturePack(const std::filesystem::path& path) : pack_(open_or_abort(path)) {}

const TexturePack::Mips* TexturePack::mips(const TileId& id) {
  if (const auto found = tiles_.find(id); found != tiles_.end()) return &found->second;
  const auto entry = pack_.find(Layer::imagery, id);
  if (!entry) return nullptr;
  const auto tile = read_texture_tile(pack_, *entry);
  if (!tile) return nullptr;
  Mips mips;
  std::size_t at = 0;
  for (int side = tile->size; side > 0; side /= 2) {
    auto& mip = mips.emplace_back(static_cast<std::size_t>(4 * side * side));
    const std::size_t bytes = texture_image_bytes(tile->format, side);
    if (!decode_texture(tile->format, std::span(tile->texels).subspan(at, bytes), side, side, mip).ok())
      return nullptr;
    at += bytes;
  }
  return &tiles_.emplace(id, std::move(mips)).first->second;
}

std::optional<std::array<int, 3>> TexturePack::colour(LonLat place, int dx, int dy) {
  const double step = tile_width_degrees(finest()) / size();
  const LonLat moved{place.lon + dx * step, place.lat - dy * step};
  const TileId id = tile_at(moved, finest());
  const Mips* found = mips(id);
  if (found == nullptr) return std::nullopt;
  const GeoBounds b = tile_bounds(id);
  const int c = std::min(size() - 1, static_cast<int>((moved.lon - b.west) / step));
  const int r = std::min(size() - 1, static_cast<int>((b.north - moved.lat) / step));
  const std::uint8_t* texel = &(*found)[0][static_cast<std::size_t>(4 * (r * size() + c))];
  if (texel[3] != 255) return std::nullopt;
  return std::array<int, 3>{texel[0], texel[1], texel[2]};
}

SeamDifferences seam_differences(TexturePack& pack, std::optional<int> level, int mip) {
  const int side = pack.size() >> mip;
  Mean across, beside, inside;
  const auto at = [&](const TexturePack::Mips& mips, int c, int r) {
    return &mips[static_cast<std::size_t>(mip)][static_cast<std::size_t>(4 * (r * side + c))];
  };
  for (std::size_t i = 0; i < pack.pack().entry_count(); ++i) {
    const IndexEntry entry = pack.pack().entry(i);
    if (entry.layer != Layer::imagery || entry.id.level != level.value_or(entry.id.level)) continue;
    const auto* own = pack.mips(entry.id);
    const auto* east = pack.mips(neighbour_of(entry.id, 1, 0));
    const auto* north = pack.mips(neighbour_of(entry.id, 0, 1));
    for (int k = 0; k < side; ++k) {
      if (east != nullptr) across.add(at(*own, side - 1, k), at(*east, 0, k));
      if (east != nullptr && side > 1) beside.add(at(*own, side - 1, k), at(*own, side - 2, k));
      if (east != nullptr && side > 1) beside.add(at(*east, 0, k), at(*east, 1, k));
      if (north != nullptr) across.add(at(*own, k, 0), at(*north, k, side - 1));
      if (north != nullptr && side > 1) beside.add(at(*own, k, 0), at(*own, k, 1));
      for (int j = 1; j < side; ++j) {
        inside.add(at(*own, j, k), at(*own, j - 1, k));
        inside.add(at(*own, k, j), at(*own, k, j - 1));
      }
    }
  }
  return {across.value(), beside.value(), inside.value(), across.count / 3};
}

}  // namespace cairn::test
