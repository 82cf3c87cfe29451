#include "builder/export/pmtiles_export.h"

#include <algorithm>
#include <map>
#include <span>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/task_arena.h>

#include "builder/bake/pipeline.h"
#include "builder/export/export_folder.h"
#include "format/file.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kBatchTiles = 16;
constexpr const char* kWhole = "whole";  // the archive's name before it has its own

struct Batch {
  std::vector<std::byte> bytes;  // of all its tiles
  std::vector<std::size_t> ends;
  std::vector<ExportLevel> parts;  // one a tile
};

void add_part(const ExportLevel& part, ExportLevel& sum) {
  sum.level = part.level;
  sum.tiles += part.tiles;
  sum.bytes += part.bytes;
  if (part.max_error_m <= sum.max_error_m && !sum.worst.empty()) return;
  sum.max_error_m = part.max_error_m;
  sum.worst = part.worst;
}

class ArchiveExport {
 public:
  ArchiveExport(const PmtilesPlan& plan, const ExportOptions& options, const ProgressCallback& progress)
      : plan_(plan), options_(options), progress_(progress) {}

  Result<std::vector<ExportLevel>> run();

 private:
  void list(const MercatorTile& tile);
  std::size_t batches() const { return (tiles_.size() + kBatchTiles - 1) / kBatchTiles; }
  Result<Batch> make(std::size_t i) const;
  Status take(ExportFolder& folder, std::size_t i, Batch&& batch);
  Status replay(const std::string& line);
  Status write_archive(const ExportFolder& folder, const std::vector<ExportLevel>& levels) const;

  const PmtilesPlan& plan_;
  const ExportOptions& options_;
  const ProgressCallback& progress_;
  std::vector<MercatorTile> tiles_;             // in the archive's order
  std::vector<std::vector<std::size_t>> ends_;  // of the finished batches' tiles
  std::map<int, ExportLevel> levels_;
  Progress now_;
};

void ArchiveExport::list(const MercatorTile& tile) {
  if (!plan_.has(tile)) return;
  if (tile.zoom >= plan_.min_zoom) tiles_.push_back(tile);
  if (tile.zoom == plan_.max_zoom) return;
  for (int q = 0; q < 4; ++q) list({tile.zoom + 1, 2 * tile.x + (q & 1), 2 * tile.y + (q >> 1)});
}

Result<Batch> ArchiveExport::make(std::size_t i) const {
  Batch batch;
  const std::size_t first = i * kBatchTiles, count = std::min(tiles_.size() - first, kBatchTiles);
  const auto made = plan_.make(std::span(tiles_).subspan(first, count));
  if (!made) return made.error();
  for (std::size_t t = 0; t < count; ++t) {
    const PmtilesTile& one = (*made)[t];
    batch.bytes.insert(batch.bytes.end(), one.bytes.begin(), one.bytes.end());
    batch.ends.push_back(batch.bytes.size());
    if (one.bytes.empty()) continue;
    // A batch may hold tiles of two zooms: each is noted by itself.
    const MercatorTile& tile = tiles_[first + t];
    batch.parts.push_back({tile.zoom, 1, one.bytes.size(), 0, 0, 0, one.measure,
                           fmt::format("{}/{}/{}", tile.zoom, tile.x, tile.y)});
  }
  return batch;
}

Status ArchiveExport::take(ExportFolder& folder, std::size_t i, Batch&& batch) {
  if (auto status = folder.write(std::to_string(i), batch.bytes); !status) return status;
  Json line = {{"batch", i}, {"ends", batch.ends}, {"tiles", Json::array()}};
  for (const ExportLevel& part : batch.parts)
    line["tiles"].push_back({part.level, part.bytes, part.max_error_m, part.worst});
  const std::string text = line.dump();
  if (auto status = replay(text); !status) return status;
  if (auto status = folder.append(text); !status) return status;
  now_.done = i + 1;
  now_.bytes_written += batch.bytes.size();
  return progress_(now_)
             ? Status()
             : Status(failed(fmt::format("export: cancelled after {} of {} parts", i + 1, now_.total)));
}

/// Counts a finished batch.
Status ArchiveExport::replay(const std::string& line) {
  const Json json = Json::parse(line, nullptr, false);
  if (!json.is_object() || !json.contains("ends") || json.value("batch", SIZE_MAX) != ends_.size())
    return bad_data(options_.target.string() + ".part: journal: expected a finished part, found " + line);
  ends_.push_back(json.at("ends").get<std::vector<std::size_t>>());
  for (const Json& tile : json.at("tiles"))
    add_part({tile.at(0), 1, tile.at(1), 0, 0, 0, tile.at(2), tile.at(3)}, levels_[tile.at(0).get<int>()]);
  return {};
}

Status ArchiveExport::write_archive(const ExportFolder& folder,
                                    const std::vector<ExportLevel>& levels) const {
  auto archive = PmtilesWriter::create(folder.path() / kWhole);
  if (!archive) return archive.error();
  for (std::size_t i = 0; i < ends_.size(); ++i) {
    const auto file = File::open_to_read(folder.path() / std::to_string(i));
    if (!file) return file.error();
    std::vector<std::byte> bytes(ends_[i].back());
    if (auto status = file->read(0, bytes); !status) return status;
    std::size_t from = 0;
    for (std::size_t t = 0; t < ends_[i].size(); ++t) {
      const std::size_t end = ends_[i][t];
      if (end == from) continue;
      if (auto status = archive->add(pmtiles_id(tiles_[i * kBatchTiles + t]),
                                     std::span(bytes).subspan(from, end - from));
          !status)
        return status;
      from = end;
    }
  }
  PmtilesInfo info;
  info.type = plan_.type;
  info.min_zoom = levels.front().level;
  info.max_zoom = levels.back().level;
  info.bounds = plan_.bounds;
  info.metadata = plan_.metadata(levels);
  return archive->finish(info);
}

Result<std::vector<ExportLevel>> ArchiveExport::run() {
  list({0, 0, 0});
  const Error none = failed(
      "expected something to show between 85.05 degrees south and north in the region and at these zooms, "
      "the pack has nothing");
  if (tiles_.empty()) return none;
  std::sort(tiles_.begin(), tiles_.end(),
            [](const MercatorTile& a, const MercatorTile& b) { return pmtiles_id(a) < pmtiles_id(b); });
  auto folder = ExportFolder::begin(options_.target, plan_.identity, options_.resume);
  if (!folder) return folder.error();
  now_ = {"export", 0, batches(), 0};
  for (const std::string& line : folder->done())
    if (auto status = replay(line); !status) return status.error();
  tbb::task_arena arena(options_.threads);
  const Status made = arena.execute([&] {
    return run_in_order<Batch>(
        folder->done().size(), batches(), static_cast<std::size_t>(options_.threads) + 1,
        [&](std::size_t i) { return make(i); },
        [&](std::size_t i, Batch&& batch) { return take(*folder, i, std::move(batch)); });
  });
  if (!made) return made.error();
  std::vector<ExportLevel> levels;
  for (const auto& [zoom, level] : levels_) levels.push_back(level);
  if (levels.empty()) {
    folder->discard();
    return none;
  }
  if (auto status = plan_.check(levels); !status) return status.error();
  if (auto status = write_archive(*folder, levels); !status) return status.error();
  if (auto status = folder->finish_as_file(kWhole); !status) return status.error();
  return levels;
}

}  // namespace

Status choose_zooms(const ExportOptions& options, PmtilesPlan& plan) {
  plan.max_zoom = std::min(plan.max_zoom, kMostZoom);
  if (!options.levels) return {};
  plan.min_zoom = options.levels->coarsest;
  plan.max_zoom = options.levels->finest;
  if (plan.min_zoom >= 0 && plan.max_zoom <= kMostZoom) return {};
  return usage_error(fmt::format("levels: expected zooms of 0 to {}, found {} to {}", kMostZoom,
                                 plan.min_zoom, plan.max_zoom));
}

GeoBounds bounds_of_archive(GeoBounds b) {
  if (b.east > 180) b.west = -180, b.east = 180;
  return {std::max(b.west, -180.0), std::max(b.south, -kMercatorLimit), b.east,
          std::min(b.north, kMercatorLimit)};
}

Result<std::vector<ExportLevel>> write_pmtiles(const PmtilesPlan& plan, const ExportOptions& options,
                                               const ProgressCallback& progress) {
  return ArchiveExport(plan, options, progress).run();
}

}  // namespace cairn
