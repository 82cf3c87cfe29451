// The C interface over PackReader and PackSampler. Nothing is thrown into C.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>
#include <limits>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "cairn/cairn.h"
#include "cairn/pack_reader.h"
#include "cairn/pack_sampler.h"
#include "format/imagery_tile.h"

/// A pack, and the samplers that no call uses at the moment: a sampler belongs to one thread at a time and
/// keeps decoded tiles from call to call.
struct cairn_pack {
  explicit cairn_pack(cairn::PackReader opened) : reader(std::move(opened)), info(reader.metadata_json()) {}

  std::unique_ptr<cairn::PackSampler> borrow_sampler() const {
    const std::lock_guard lock(mutex);
    if (idle.empty()) return std::make_unique<cairn::PackSampler>(reader);
    auto sampler = std::move(idle.back());
    idle.pop_back();
    return sampler;
  }
  void give_back(std::unique_ptr<cairn::PackSampler> sampler) const {
    const std::lock_guard lock(mutex);
    idle.push_back(std::move(sampler));
  }

  cairn::PackReader reader;
  std::string info;
  mutable std::mutex mutex;
  mutable std::vector<std::unique_ptr<cairn::PackSampler>> idle;  // guarded by mutex
};

namespace cairn {
namespace {

cairn_result report(cairn_result result, const char* text, cairn_error* error) {
  if (error == nullptr) return result;
  const std::size_t length = std::min(std::strlen(text), sizeof error->text - 1);
  std::memcpy(error->text, text, length);
  error->text[length] = '\0';
  return result;
}

cairn_result report(const Error& failure, cairn_error* error) {
  return report(static_cast<cairn_result>(failure.code), failure.message.c_str(), error);
}

/// Runs `work`, and turns what it throws (out of memory, at worst) into an error.
template <class Work>
cairn_result guarded(cairn_error* error, const Work& work) {
  try {
    report(CAIRN_OK, "", error);
    return work();
  } catch (const std::exception& failure) {
    return report(CAIRN_FAILED, failure.what(), error);
  }
}

/// The entry of a tile that the caller has room for.
Result<IndexEntry> find_tile(const cairn_pack& pack, Layer layer, const TileId& id, std::size_t expected,
                             std::size_t count) {
  const std::string place = pack.reader.path().string() + ": " + to_string(layer) + " tile " + to_string(id);
  if (!is_valid(id)) return usage_error(place + ": expected a tile of the grid, found none");
  if (count != expected) {
    return usage_error(place + ": expected room for " + std::to_string(expected) + " values, found " +
                       std::to_string(count));
  }
  const auto entry = pack.reader.find(layer, id);
  if (!entry) return Error{static_cast<ErrorCode>(CAIRN_ABSENT), place + ": expected a tile, found none"};
  return *entry;
}

Status read_heights(const cairn_pack& pack, const TileId& id, float* height_m, std::size_t count) {
  const PackHeader& header = pack.reader.header();
  const auto side = static_cast<std::size_t>(header.tile_size);
  const auto entry = find_tile(pack, Layer::heights, id, side * side, count);
  if (!entry) return entry.error();
  const auto tile = pack.reader.read_height_tile(*entry);
  if (!tile) return tile.error();
  for (std::size_t i = 0; i < count; ++i) {
    const bool is_void = !tile->voids.empty() && tile->voids[i] != 0;
    height_m[i] = is_void ? std::numeric_limits<float>::quiet_NaN()
                          : static_cast<float>(tile->samples[i] * header.quantum_m);
  }
  return {};
}

Status read_imagery(const cairn_pack& pack, const TileId& id, std::uint8_t* rgba, std::size_t count) {
  const int side = pack.reader.header().tile_size - 1;
  const auto texels = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
  const auto entry = find_tile(pack, Layer::imagery, id, texels * 4, count);
  if (!entry) return entry.error();
  const auto tile = read_imagery_tile(pack.reader, *entry);
  if (!tile) return tile.error();
  std::copy(tile->begin(), tile->end(), rgba);
  return {};
}

Status sample_heights(PackSampler& sampler, std::size_t count, const double* lon, const double* lat,
                      double* height_m) {
  std::fill_n(height_m, count, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(lon[i]) || !std::isfinite(lat[i])) continue;
    const auto height = sampler.height_at({lon[i], lat[i]});
    if (!height) return height.error();
    if (*height) height_m[i] = (*height)->metres;
  }
  return {};
}

}  // namespace
}  // namespace cairn

const char* cairn_version(void) {
  return CAIRN_VERSION;
}

cairn_result cairn_open(const char* path, cairn_pack** pack, cairn_error* error) {
  *pack = nullptr;
  return cairn::guarded(error, [&] {
    auto reader = cairn::PackReader::open(path);
    if (!reader) return cairn::report(reader.error(), error);
    *pack = new cairn_pack(*std::move(reader));
    return CAIRN_OK;
  });
}

void cairn_close(cairn_pack* pack) {
  delete pack;
}

const char* cairn_info(const cairn_pack* pack) {
  return pack->info.c_str();
}

int cairn_tile_size(const cairn_pack* pack) {
  return pack->reader.header().tile_size;
}

cairn_result cairn_sample_heights(const cairn_pack* pack, size_t count, const double* lon, const double* lat,
                                  double* height_m, cairn_error* error) {
  return cairn::guarded(error, [&] {
    auto sampler = pack->borrow_sampler();
    const cairn::Status status = cairn::sample_heights(*sampler, count, lon, lat, height_m);
    pack->give_back(std::move(sampler));
    return status ? CAIRN_OK : cairn::report(status.error(), error);
  });
}

cairn_result cairn_read_heights(const cairn_pack* pack, int level, int32_t x, int32_t y, float* height_m,
                                size_t count, cairn_error* error) {
  return cairn::guarded(error, [&] {
    const cairn::Status status = cairn::read_heights(*pack, {level, x, y}, height_m, count);
    return status ? CAIRN_OK : cairn::report(status.error(), error);
  });
}

cairn_result cairn_read_imagery(const cairn_pack* pack, int level, int32_t x, int32_t y, uint8_t* rgba,
                                size_t count, cairn_error* error) {
  return cairn::guarded(error, [&] {
    const cairn::Status status = cairn::read_imagery(*pack, {level, x, y}, rgba, count);
    return status ? CAIRN_OK : cairn::report(status.error(), error);
  });
}
