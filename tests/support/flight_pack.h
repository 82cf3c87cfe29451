#pragma once

#include <filesystem>
#include <memory>

#include "cairn/pack_reader.h"
#include "cairn/read_tile.h"
#include "tests/support/test_data.h"

namespace cairn::test {

/// A pack of 257² tiles from level -9 to 5: the whole Earth to level -4, 3°×2° about 28°E 37°N further down,
/// and a seventh of the tiles finer than level 1 left out with all below them. Every tile has one of 16
/// contents.
class FlightPack {
 public:
  /// `coarsest` above -9 leaves out what is coarser; 0 and finer leave the detailed region only.
  explicit FlightPack(int coarsest = kMinLevel);
  std::shared_ptr<const PackReader> open() const;
  const std::filesystem::path& path() const { return path_; }

  /// The first sample of the tile's content.
  static std::int32_t first_sample(const TileId& id);

  static constexpr LonLat kMiddle{28.5, 37.0};
  static constexpr int kFinest = 5;

 private:
  TempDir dir_;
  std::filesystem::path path_;
};

/// Writes a pack of 257² heights and 256² imagery along the path of tiles from level -9 to the place, both
/// with all four children of every tile on the path, down to these levels.
void write_imagery_pack(const std::filesystem::path& path, LonLat place, int finest_heights,
                        int finest_imagery);

/// A disk that is slow, fails now and then, and has damaged places; the same places every time.
struct Faults {
  int longest_delay_ms = 0;  ///< each read takes 0 to this
  double failing_share = 0;  ///< of reads, by their number
  double damaged_share = 0;  ///< of tiles, level -9 excepted
  bool is_damaged(const TileKey& key) const;
};
ReadTile read_with(std::shared_ptr<const PackReader> pack, const Faults& faults);

/// Bytes allocated with operator new and not yet freed: now, and the most since reset_peak().
std::uint64_t heap_bytes();
std::uint64_t peak_heap_bytes();
void reset_peak_heap_bytes();

}  // namespace cairn::test
