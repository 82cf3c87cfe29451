#include "runtime/paging/tile_loader.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace cairn {
namespace {

Result<LoadedTile> read_heights(const PackReader& pack, const IndexEntry& entry) {
  Result<HeightTile> tile = pack.read_height_tile(entry);
  if (!tile) return tile.error();
  return LoadedTile{std::make_shared<const HeightTile>(std::move(*tile)), nullptr};
}

/// The colour of a constant tile is the index's: R, G, B, A from the lowest byte.
TextureTile solid_texture(std::uint32_t rgba, int size) {
  TextureTile tile{TextureFormat::bc3, size, {}};
  tile.texels.resize(texture_chain_bytes(tile.format, size));
  const std::uint32_t r = rgba & 255, g = rgba >> 8 & 255, b = rgba >> 16 & 255, a = rgba >> 24;
  const std::uint32_t colour = (r * 31 + 127) / 255 << 11 | (g * 63 + 127) / 255 << 5 | (b * 31 + 127) / 255;
  for (std::size_t block = 0; block < tile.texels.size(); block += 16) {
    tile.texels[block] = static_cast<std::byte>(a);
    tile.texels[block + 8] = tile.texels[block + 10] = static_cast<std::byte>(colour & 255);
    tile.texels[block + 9] = tile.texels[block + 11] = static_cast<std::byte>(colour >> 8);
  }
  return tile;
}

Result<LoadedTile> read_imagery(const PackReader& pack, const IndexEntry& entry) {
  const int size = pack.header().tile_size - 1;
  if ((entry.flags & kConstant) != 0) {
    return LoadedTile{nullptr, std::make_shared<const TextureTile>(
                                   solid_texture(static_cast<std::uint32_t>(entry.min_quanta), size))};
  }
  const Result<std::vector<std::byte>> block = pack.read_block(entry);
  if (!block) return block.error();
  Result<TextureTile> tile = decode_texture_block(*block, size);
  if (!tile) {
    return Error{tile.error().code, pack.path().string() + ": imagery tile " + to_string(entry.id) + ": " +
                                        tile.error().message};
  }
  return LoadedTile{nullptr, std::make_shared<const TextureTile>(std::move(*tile))};
}

}  // namespace

ReadTile read_from(std::shared_ptr<const PackReader> pack) {
  return [pack = std::move(pack)](const IndexEntry& entry) {
    return entry.layer == Layer::heights ? read_heights(*pack, entry) : read_imagery(*pack, entry);
  };
}

TileLoader::TileLoader(ReadTile read, int workers) : read_(std::move(read)) {
  assert(workers >= 1);
  for (int i = 0; i < workers; ++i) {
    workers_.emplace_back([this](const std::stop_token& stop) { work(stop); });
  }
}

TileLoader::~TileLoader() {
  for (std::jthread& worker : workers_) worker.request_stop();
}

void TileLoader::submit(const IndexEntry& entry) {
  {
    const std::lock_guard lock(mutex_);
    queue_.push_back(entry);
  }
  wake_.notify_one();
}

std::vector<TileKey> TileLoader::withdraw(const std::function<bool(const TileKey&)>& stale) {
  std::vector<TileKey> withdrawn;
  const std::lock_guard lock(mutex_);
  std::erase_if(queue_, [&](const IndexEntry& entry) {
    if (!stale(key_of(entry))) return false;
    withdrawn.push_back(key_of(entry));
    return true;
  });
  return withdrawn;
}

std::vector<LoadResult> TileLoader::take(std::uint64_t limit_bytes) {
  std::vector<LoadResult> taken;
  std::uint64_t bytes = 0;
  const std::lock_guard lock(mutex_);
  while (!finished_.empty() && (taken.empty() || bytes < limit_bytes)) {
    taken.push_back(std::move(finished_.front()));
    finished_.pop_front();
    if (taken.back().tile) bytes += taken.back().tile->bytes();
  }
  return taken;
}

void TileLoader::work(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (wake_.wait(lock, stop, [this] { return !queue_.empty(); }) && !stop.stop_requested()) {
    const IndexEntry entry = queue_.front();
    queue_.pop_front();
    lock.unlock();
    LoadResult result{entry, read_(entry)};
    lock.lock();
    finished_.push_back(std::move(result));
  }
}

}  // namespace cairn
