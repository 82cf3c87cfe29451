#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "builder/export/vertical_shift.h"
#include "cairn/geo.h"
#include "cairn/pack_reader.h"
#include "cairn/progress.h"
#include "cairn/status.h"

namespace cairn {

/// What of a pack is exported, and how. A format refuses what has no meaning for it.
struct ExportOptions {
  std::filesystem::path target;
  std::optional<GeoBounds> region;
  std::optional<double> max_error_m;
  struct Levels {
    int coarsest = 0;
    int finest = 0;
  };
  std::optional<Levels> levels;          ///< of the format's own tiles
  std::optional<VerticalDatum> datum;    ///< of the pack, where the pack does not know it
  std::optional<ExportHeights> heights;  ///< where the format's own choice is not wanted
  std::filesystem::path geoid;
  int posts = 1009;                 ///< along a side of a tile of an engine's heightmap
  std::optional<double> spacing_m;  ///< metres from one of its posts to the next
  std::size_t memory_bytes = std::size_t{1024} << 20;
  int threads = 1;
  bool resume = false;
};

/// What an export measured of one of its levels.
struct ExportLevel {
  int level = 0;
  std::uint64_t tiles = 0;
  std::uint64_t bytes = 0;
  std::uint64_t vertices = 0;  ///< of meshes
  std::uint64_t triangles = 0;
  double bound_m = 0;      ///< what was to be kept
  double max_error_m = 0;  ///< against the source posts, as far as the pack knows them
  std::string worst;       ///< the tile that has the largest error or change
  double colour_rms = 0;   ///< of imagery: what compression changed, of 255
};

struct ExportReport {
  std::vector<ExportLevel> levels;
  bool is_imagery = false;                       ///< and no heights
  VerticalDatum datum = VerticalDatum::unknown;  ///< of the exported heights
  std::vector<std::string> notes;                ///< for a person: whole sentences
};

/// One format that packs are exported to. Each file of builder/export/formats/ defines one; the folder is the
/// list.
struct ExportFormat {
  const char* name;
  const char* summary;
  /// Nothing is left at the target after an error but what `resume` goes on from.
  Result<ExportReport> (*write)(const PackReader& pack, const ExportOptions& options,
                                const ProgressCallback& progress);
};
std::span<const ExportFormat* const> export_formats();

/// The datum of the pack's heights: its own, or the one that the options tell where the pack does not know
/// it. usage where both are known and differ.
Result<VerticalDatum> datum_of(const PackReader& pack, const ExportOptions& options);

}  // namespace cairn
