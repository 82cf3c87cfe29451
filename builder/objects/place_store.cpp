#include "builder/objects/place_store.h"

#include <algorithm>
#include <queue>
#include <span>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "format/tile_number.h"

namespace cairn {
namespace {

constexpr std::size_t kReadPlaces = 512;
using PlaceRecord = PlaceStore::Record;
static_assert(std::is_trivially_copyable_v<PlaceRecord>);

/// Finer levels first.
std::uint64_t key_of(const TileId& tile) {
  return static_cast<std::uint64_t>(kMaxLevel - tile.level) << 59 | tile_number(tile);
}

auto order_of(const PlaceRecord& r) {
  const PlacedObject& o = r.place.object;
  return std::tuple(r.key, o.model, z_curve(o.x, o.y), o.height_quanta, o.heading, o.scale,
                    r.place.is_absolute, r.place.absolute_m);
}

bool record_before(const PlaceRecord& a, const PlaceRecord& b) {
  if (a.key != b.key) return a.key < b.key;
  return order_of(a) < order_of(b);
}

}  // namespace

/// The places of a run, one after the other.
class PlaceStore::RunReader {
 public:
  RunReader(const File& scratch, const Run& run) : scratch_(&scratch), rest_(run) {}
  /// Places that are in memory.
  explicit RunReader(std::vector<PlaceRecord> sorted) : buffer_(std::move(sorted)) {}

  /// False at the end.
  Result<bool> next() {
    if (++at_ < buffer_.size()) return true;
    if (rest_.places == 0) return false;
    buffer_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(rest_.places, kReadPlaces)));
    const auto bytes = std::as_writable_bytes(std::span(buffer_));
    if (const Status status = scratch_->read(rest_.offset, bytes); !status) return status.error();
    rest_.offset += bytes.size();
    rest_.places -= buffer_.size();
    at_ = 0;
    return true;
  }
  const PlaceRecord& record() const { return buffer_[at_]; }

 private:
  const File* scratch_ = nullptr;
  Run rest_;
  std::vector<PlaceRecord> buffer_;
  std::size_t at_ = static_cast<std::size_t>(-1);  // next() comes before record()
};

PlaceStore::PlaceStore(std::filesystem::path folder, std::size_t run_places)
    : folder_(std::move(folder)), run_places_(run_places) {}

Status PlaceStore::add(const StoredPlace& place) {
  ++size_;
  latest_.push_back({key_of(place.tile), place});
  return latest_.size() < run_places_ ? Status() : write_run();
}

Status PlaceStore::write_run() {
  if (!scratch_) {
    auto file = File::open_scratch(folder_);
    if (!file) return file.error();
    scratch_ = std::move(*file);
  }
  std::sort(latest_.begin(), latest_.end(), record_before);
  const auto bytes = std::as_bytes(std::span(latest_));
  if (const Status status = scratch_->write(scratch_bytes_, bytes); !status) return status;
  runs_.push_back({scratch_bytes_, latest_.size()});
  scratch_bytes_ += bytes.size();
  latest_.clear();
  return {};
}

Status PlaceStore::visit(const TakeTile& take) {
  std::vector<RunReader> readers;
  for (const Run& run : runs_) readers.emplace_back(*scratch_, run);
  std::sort(latest_.begin(), latest_.end(), record_before);
  readers.emplace_back(std::move(latest_));
  latest_ = {};

  const auto later = [&readers](std::size_t a, std::size_t b) {
    return record_before(readers[b].record(), readers[a].record());
  };
  std::priority_queue<std::size_t, std::vector<std::size_t>, decltype(later)> next(later);
  const auto advance = [&](std::size_t i) -> Status {
    const auto more = readers[i].next();
    if (!more) return more.error();
    if (*more) next.push(i);
    return {};
  };
  for (std::size_t i = 0; i < readers.size(); ++i) {
    if (Status status = advance(i); !status) return status;
  }
  std::vector<StoredPlace> tile;
  while (!next.empty()) {
    const std::size_t i = next.top();
    next.pop();
    const StoredPlace place = readers[i].record().place;
    if (!tile.empty() && tile.front().tile != place.tile) {
      const TileId id = tile.front().tile;
      if (Status status = take(id, std::exchange(tile, {})); !status) return status;
    }
    tile.push_back(place);
    if (tile.size() > kMostObjects)
      return bad_data("objects: tile " + to_string(place.tile) + ": expected at most " +
                      std::to_string(kMostObjects) + " objects, found more");
    if (Status status = advance(i); !status) return status;
  }
  if (tile.empty()) return {};
  const TileId id = tile.front().tile;
  return take(id, std::move(tile));
}

}  // namespace cairn
