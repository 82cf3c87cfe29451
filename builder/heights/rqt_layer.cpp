#include "builder/heights/rqt_layer.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "builder/bake/pipeline.h"
#include "builder/bake/pyramid.h"
#include "format/checksum.h"
#include "format/file.h"
#include "format/height_block.h"
#include "format/rqt_block.h"
#include "format/rqt_borders.h"
#include "format/rqt_triangulate.h"

namespace cairn {
namespace {

constexpr std::size_t kTilesInUnit = 16;

using Entries = std::vector<IndexEntry>;
using Units = std::vector<Entries>;

/// The height tiles by level, the coarsest first, in the order in which the pack has them.
std::map<int, Units> units_by_level(const Entries& entries) {
  std::map<int, Units> levels;
  for (const IndexEntry& entry : entries) {
    if (entry.layer != Layer::heights) continue;
    Units& units = levels[entry.id.level];
    if (units.empty() || units.back().size() == kTilesInUnit) units.emplace_back();
    units.back().push_back(entry);
  }
  return levels;
}

/// The heights of a pack that is not finished yet.
class PartReader {
 public:
  PartReader(File part, int tile_size) : part_(std::move(part)), tile_size_(tile_size) {}

  Result<HeightTile> read(const IndexEntry& entry) const {
    if ((entry.flags & kConstant) != 0) {
      const auto side = static_cast<std::size_t>(tile_size_);
      return HeightTile{tile_size_, std::vector<std::int32_t>(side * side, entry.min_quanta), {}};
    }
    std::vector<std::byte> block(entry.bytes);
    if (auto status = part_.read(entry.offset, block); !status) return status.error();
    if (checksum(block) != entry.checksum)
      return bad_data(part_.path().string() + ": heights " + to_string(entry.id) +
                      ": expected the block as it was written, found another");
    return decode_height_block(block, tile_size_);
  }

 private:
  File part_;
  int tile_size_;
};

class RqtLevel {
 public:
  RqtLevel(const RqtPlan& plan, const PartReader& heights, const Units& units, int threads)
      : plan_(plan),
        heights_(heights),
        units_(units),
        in_flight_(static_cast<std::size_t>(threads) + 1),
        borders_(plan.tile_size),
        tolerance_m_(std::ldexp(plan.tolerance_m, plan.finest - units.front().front().id.level)) {}

  /// Every tile for itself, then the borders.
  Status agree() {
    const auto status = run_in_order<Triangulated>(
        0, units_.size(), in_flight_, [&](std::size_t u) { return triangulate_unit(units_[u]); },
        [&](std::size_t u, Triangulated&& unit) -> Status {
          for (std::size_t i = 0; i < unit.size(); ++i) borders_.add(units_[u][i].id, unit[i]);
          return {};
        });
    if (status) borders_.settle();
    return status;
  }

  /// Every tile again, from unit `first` on, with what its neighbours need.
  template <class Sink>
  Status emit(std::size_t first, const Sink& sink) const {
    return run_in_order<std::vector<TileBlock>>(
        first, units_.size(), in_flight_, [&](std::size_t u) { return encode_unit(units_[u]); },
        [&](std::size_t u, std::vector<TileBlock>&& blocks) { return sink(units_[u].size(), blocks); });
  }

 private:
  using Triangulated = std::vector<RqtSteps>;

  Result<Triangulated> triangulate_unit(const Entries& unit) const {
    Triangulated result;
    for (const IndexEntry& entry : unit) {
      const auto tile = heights_.read(entry);
      if (!tile) return tile.error();
      result.push_back(triangulate(*tile, plan_.quantum_m, tolerance_m_, kRqtSteps, root_rises(entry.id)));
    }
    return result;
  }

  Result<std::vector<TileBlock>> encode_unit(const Entries& unit) const {
    auto triangulated = triangulate_unit(unit);
    if (!triangulated) return triangulated.error();
    std::vector<TileBlock> blocks;
    for (std::size_t i = 0; i < unit.size(); ++i) {
      RqtSteps& vertices = (*triangulated)[i];
      borders_.apply(unit[i].id, vertices);
      IndexEntry entry;
      entry.layer = Layer::rqt;
      entry.id = unit[i].id;
      entry.geometric_error_m = tolerance_m_;
      entry.min_quanta = static_cast<std::int32_t>(vertices.triangle_count(kRqtSteps - 1));
      entry.max_quanta = static_cast<std::int32_t>(vertices.triangle_count(0));
      blocks.push_back({entry, encode_rqt_block({tolerance_m_, kRqtSteps, std::move(vertices)})});
    }
    return blocks;
  }

  const RqtPlan& plan_;
  const PartReader& heights_;
  const Units& units_;
  std::size_t in_flight_;
  RqtBorders borders_;
  float tolerance_m_;
};

Status write_unit(const std::vector<TileBlock>& blocks, BakeSession& session) {
  UnitRecord record;
  for (const TileBlock& block : blocks) {
    auto entry = session.writer.add(block.entry, block.block);
    if (!entry) return entry.error();
    record.entries.push_back(*entry);
  }
  // The journal must not speak of blocks that a killed process would still hold.
  if (auto status = session.writer.flush(); !status) return status;
  return session.journal.append(record);
}

}  // namespace

Status bake_rqt_layer(const RqtPlan& plan, const std::filesystem::path& target, int threads,
                      BakeSession& session, const ProgressCallback& progress) {
  if (auto status = session.writer.flush(); !status) return status;
  auto part = File::open_to_read(std::filesystem::path(target).concat(".part"));
  if (!part) return part.error();
  const PartReader heights(std::move(*part), plan.tile_size);
  const std::map<int, Units> levels = units_by_level(session.writer.entries());
  const auto samples =
      static_cast<std::uint64_t>(plan.tile_size - 1) * static_cast<std::uint64_t>(plan.tile_size - 1);
  Progress now{"rqt", 0, 0, session.writer.position()};
  for (const auto& [level, units] : levels) {
    for (const Entries& unit : units) now.total += unit.size() * samples;
  }
  std::size_t done = session.done.size();
  session.done.clear();
  for (const auto& [level, units] : levels) {
    const std::size_t skipped = std::min(done, units.size());
    done -= skipped;
    for (std::size_t u = 0; u < skipped; ++u) now.done += units[u].size() * samples;
    if (skipped == units.size()) continue;
    RqtLevel bake(plan, heights, units, threads);
    if (auto status = bake.agree(); !status) return status;
    const auto status = bake.emit(skipped, [&](std::size_t tiles, const std::vector<TileBlock>& blocks) {
      auto written = write_unit(blocks, session);
      now.done += tiles * samples;
      now.bytes_written = session.writer.position();
      progress(now);
      return written;
    });
    if (!status) return status;
  }
  return {};
}

}  // namespace cairn
