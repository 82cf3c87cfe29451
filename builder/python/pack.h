#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "cairn/pack_reader.h"
#include "cairn/pack_sampler.h"
#include "cairn/status.h"
#include "format/imagery_sampler.h"

namespace cairn {

/// Where the answers for many places go, one element a place.
struct HeightAnswers {
  std::span<double> metres;       ///< NaN where there is none
  std::span<std::int8_t> levels;  ///< of the tile; kNoLevel where there is none
  std::span<float> errors_m;      ///< geometric error of the tile; NaN where there is none
};
inline constexpr std::int8_t kNoLevel = -128;

/// Pixels over an area, rows from the north; their values are those at their centres.
struct Window {
  GeoBounds bounds;
  std::size_t rows = 0;
  std::size_t columns = 0;

  LonLat centre(std::size_t row, std::size_t column) const {
    return {bounds.west + (static_cast<double>(column) + 0.5) * bounds.width() / static_cast<double>(columns),
            bounds.north - (static_cast<double>(row) + 0.5) * bounds.height() / static_cast<double>(rows)};
  }
};

/// A pack as Python has it: any number of threads may call it at once. Decoded tiles stay from call to call.
class Pack {
 public:
  static Result<std::unique_ptr<Pack>> open(const std::filesystem::path& path);

  const PackReader& reader() const { return reader_; }

  /// The heights at places in any order; each tile is decoded about once a call. Only `level` is asked where
  /// it is given. REQUIRES: lon, lat and all of `out` have one size.
  Status heights(std::span<const double> lon, std::span<const double> lat, std::optional<int> level,
                 HeightAnswers out) const;

  /// Heights of a window, row-major, NaN where there is none; and colours, RGBA. Drawn from tiles of `level`
  /// and of coarser ones.
  Status draw_heights(const Window& window, int level, std::span<double> metres) const;
  Status draw_imagery(const Window& window, int level, std::span<std::uint8_t> rgba) const;

  /// The coarsest level whose samples lie no farther apart than the window's pixels, or the finest there is.
  /// REQUIRES: the pack has the layer.
  int level_for(const Window& window, Layer layer) const;

 private:
  explicit Pack(PackReader reader) : reader_(std::move(reader)) {}

  template <class Sampler>
  struct Pool {
    std::vector<std::unique_ptr<Sampler>> idle;
  };
  template <class Sampler, class Work>
  Status with_sampler(Pool<Sampler>& pool, const Work& work) const;

  PackReader reader_;
  mutable std::mutex mutex_;
  mutable Pool<PackSampler> height_samplers_;      // guarded by mutex_
  mutable Pool<ImagerySampler> imagery_samplers_;  // guarded by mutex_
};

}  // namespace cairn
