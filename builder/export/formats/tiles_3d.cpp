// An explicit tileset of 3D Tiles 1.1 (OGC 22-025r4), each tile with the error that was measured of it.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "builder/export/export_folder.h"
#include "builder/export/export_format.h"
#include "builder/export/glb_writer.h"
#include "builder/export/imagery_view.h"
#include "builder/export/mesh_export.h"
#include "builder/export/object_tileset.h"
#include "builder/export/pack_accuracy.h"
#include "builder/export/quantized_mesh_tile.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;
using Unit = QuantizedMeshPlan::Unit;

constexpr std::size_t kThreadBytes = std::size_t{48} << 20;
constexpr const char* kTilesetName = "tileset.json";
constexpr const char* kGroundName = "ground.json";  // where there are objects beside it
const Json kAsset = {{"version", "1.1"}, {"generator", "cairn " CAIRN_VERSION}};
constexpr int kLevelsOfFile = 4;    // a tileset file has so many levels, then other files go on
constexpr double kSkirtErrors = 5;  // a skirt is so many errors of its level deep, as CesiumJS's own are
constexpr int kTexture = 512;       // pixels a side of a tile's image, and up to
constexpr int kMostTexture = 2048;  // in tiles without finer ones

using Key = std::tuple<int, std::int64_t, std::int64_t>;  // level, x, y

/// What the tree needs to know of a tile.
struct TileNote {
  double error_m = 0;
  double lowest_m = 0;
  double highest_m = 0;
};
struct MadeTile {
  GeographicTile tile;
  TileNote note;
  std::vector<std::byte> glb;
  std::size_t triangles = 0;
  std::size_t vertices = 0;
};
using MadeUnit = std::vector<MadeTile>;

/// Without the triangles over ground that the pack does not have, and without vertices that none uses.
class GroundMesh {
 public:
  explicit GroundMesh(const QuantizedMesh& mesh) : mesh_(mesh), numbers_(mesh.u.size(), kUnused) {
    for (const auto& triangle : mesh.triangles) {
      if (std::none_of(triangle.begin(), triangle.end(),
                       [&](std::uint32_t i) { return mesh.has_ground[i] != 0; }))
        continue;
      kept_.push_back(triangle);
      out_.triangles.push_back({vertex(triangle[0]), vertex(triangle[1]), vertex(triangle[2])});
    }
  }

  /// Hangs walls below the tile's edges: neighbours of another level have other vertices there.
  void add_skirts(double depth_m) {
    for (const auto& triangle : kept_)
      for (std::size_t k = 0; k < 3; ++k)
        if (is_border(triangle[k], triangle[(k + 1) % 3]))
          add_wall(triangle[k], triangle[(k + 1) % 3], depth_m);
  }

  GlbMesh take() { return std::move(out_); }

 private:
  static constexpr std::uint32_t kUnused = UINT32_MAX;

  std::uint32_t add_vertex(std::uint32_t i, double metres) {
    out_.positions.push_back(geocentric(mesh_.place(i), metres, mesh_.ellipsoid));
    out_.normals.push_back(mesh_.normals[i]);
    out_.texture.push_back({static_cast<float>(mesh_.u[i]) / QuantizedMesh::kLargest,
                            1 - static_cast<float>(mesh_.v[i]) / QuantizedMesh::kLargest});
    return static_cast<std::uint32_t>(out_.positions.size() - 1);
  }
  std::uint32_t vertex(std::uint32_t i) {
    if (numbers_[i] == kUnused) numbers_[i] = add_vertex(i, mesh_.metres(i));
    return numbers_[i];
  }
  bool is_border(std::uint32_t a, std::uint32_t b) const {
    const auto on = [](std::uint16_t p, std::uint16_t q) {
      return p == q && (p == 0 || p == QuantizedMesh::kLargest);
    };
    return on(mesh_.u[a], mesh_.u[b]) || on(mesh_.v[a], mesh_.v[b]);
  }
  void add_wall(std::uint32_t a, std::uint32_t b, double depth_m) {
    const std::uint32_t low_a = add_vertex(a, mesh_.metres(a) - depth_m),
                        low_b = add_vertex(b, mesh_.metres(b) - depth_m);
    out_.triangles.push_back({vertex(b), vertex(a), low_a});
    out_.triangles.push_back({vertex(b), low_a, low_b});
  }

  const QuantizedMesh& mesh_;
  std::vector<std::uint32_t> numbers_;
  std::vector<std::array<std::uint32_t, 3>> kept_;
  GlbMesh out_;
};

class TilesetExport {
 public:
  TilesetExport(const PackReader& pack, const ExportOptions& options, const ProgressCallback& progress)
      : pack_(pack),
        options_(options),
        progress_(progress),
        accuracy_(accuracy_of(pack)),
        imagery_(pack.levels(Layer::imagery)) {}

  Result<ExportReport> run();

 private:
  Result<MadeUnit> make(const QuantizedMeshSource& source, const Unit& unit) const;
  Result<std::vector<std::byte>> image_of(const QuantizedMeshPlan& plan, const GeographicTile& tile,
                                          const GeoBounds& bounds) const;
  Status take(const QuantizedMeshPlan& plan, ExportFolder& folder, std::size_t i, MadeUnit&& made);
  Status count(const QuantizedMeshPlan& plan, const std::string& line);
  std::vector<GeographicTile> children_of(const GeographicTile& tile) const;
  void gather();
  std::vector<GeographicTile> roots() const;
  Json node_of(const GeographicTile& tile) const;
  Status write_tileset(const ExportFolder& folder, const std::vector<GeographicTile>& roots,
                       const std::string& name, Json& file) const;
  Status write_ground_and_objects(const ExportFolder& folder, const VerticalShift& shift,
                                  ExportReport& report) const;

  const PackReader& pack_;
  const ExportOptions& options_;
  const ProgressCallback& progress_;
  PackAccuracy accuracy_;
  std::optional<PackReader::LevelRange> imagery_;
  std::vector<Unit> units_;
  std::map<Key, TileNote> tiles_;  // with the errors and heights of those below, once gathered
  std::map<int, ExportLevel> levels_;
  Progress now_;
};

/// As many pixels as the imagery has there, within limits; nothing where it has no colour.
Result<std::vector<std::byte>> TilesetExport::image_of(const QuantizedMeshPlan& plan,
                                                       const GeographicTile& tile,
                                                       const GeoBounds& bounds) const {
  if (!imagery_) return std::vector<std::byte>();
  const double texels = std::ldexp(bounds.height(), imagery_->finest) * (pack_.header().tile_size - 1);
  const bool is_leaf = !plan.has({tile.level + 1, 2 * tile.x, 2 * tile.y});
  const double most = is_leaf ? kMostTexture : kTexture;
  int size = 64;
  while (size < texels && size < most) size *= 2;
  const auto view = draw_imagery(pack_, bounds, size);
  if (!view) return view.error();
  if (view->is_empty) return std::vector<std::byte>();
  return encode_jpeg(*view);
}

Result<MadeUnit> TilesetExport::make(const QuantizedMeshSource& source, const Unit& unit) const {
  MadeUnit made;
  for (const GeographicTile& tile : source.plan.tiles_of(unit)) {
    const auto mesh = make_quantized_mesh(source, tile);
    if (!mesh) return mesh.error();
    GroundMesh surface(*mesh);
    const double depth = kSkirtErrors * assumed_error_m(tile.level, mesh->ellipsoid);
    surface.add_skirts(depth);
    GlbMesh ground = surface.take();
    if (ground.triangles.empty()) continue;
    auto image = image_of(source.plan, tile, mesh->bounds);
    if (!image) return image.error();
    ground.jpeg = std::move(*image);
    if (ground.jpeg.empty()) ground.texture.clear();
    TileNote note{mesh->error_m, static_cast<double>(mesh->highest_m), static_cast<double>(mesh->lowest_m)};
    for (std::size_t i = 0; i < mesh->u.size(); ++i) {
      note.lowest_m = std::min(note.lowest_m, mesh->metres(i));
      note.highest_m = std::max(note.highest_m, mesh->metres(i));
    }
    note.lowest_m -= depth;
    made.push_back({tile, note, encode_glb(ground), ground.triangles.size(), ground.positions.size()});
  }
  return made;
}

Status TilesetExport::take(const QuantizedMeshPlan& plan, ExportFolder& folder, std::size_t i,
                           MadeUnit&& made) {
  Json line = {{"unit", i}, {"tiles", Json::array()}};
  for (const MadeTile& t : made) {
    if (auto status = folder.write(name_of(t.tile) + ".glb", t.glb); !status) return status;
    line["tiles"].push_back({t.tile.level, t.tile.x, t.tile.y, t.note.error_m, t.note.lowest_m,
                             t.note.highest_m, t.glb.size(), t.vertices, t.triangles});
    now_.bytes_written += t.glb.size();
  }
  const std::string text = line.dump();
  if (auto status = count(plan, text); !status) return status;
  if (auto status = folder.append(text); !status) return status;
  return report_parts(i + 1, now_, progress_);
}

Status TilesetExport::count(const QuantizedMeshPlan& plan, const std::string& line) {
  const Json json = Json::parse(line, nullptr, false);
  if (!json.is_object() || !json.contains("tiles"))
    return bad_data(options_.target.string() + ".part: journal: expected a finished part, found " + line);
  for (const Json& t : json.at("tiles")) {
    const GeographicTile tile{t.at(0).get<int>(), t.at(1).get<std::int64_t>(), t.at(2).get<std::int64_t>()};
    const TileNote note{t.at(3).get<double>(), t.at(4).get<double>(), t.at(5).get<double>()};
    tiles_[{tile.level, tile.x, tile.y}] = note;
    ExportLevel& level = levels_[tile.level];
    level.level = tile.level;
    ++level.tiles;
    level.bytes += t.at(6).get<std::uint64_t>();
    level.vertices += t.at(7).get<std::uint64_t>();
    level.triangles += t.at(8).get<std::uint64_t>();
    level.bound_m = std::max(level.bound_m, plan.bound_m(tile));
    if (note.error_m <= level.max_error_m && !level.worst.empty()) continue;
    level.max_error_m = note.error_m;
    level.worst = name_of(tile);
  }
  return {};
}

std::vector<GeographicTile> TilesetExport::children_of(const GeographicTile& tile) const {
  std::vector<GeographicTile> children;
  for (int q = 0; q < 4; ++q) {
    const GeographicTile child{tile.level + 1, 2 * tile.x + (q & 1), 2 * tile.y + (q >> 1)};
    if (tiles_.contains({child.level, child.x, child.y})) children.push_back(child);
  }
  return children;
}

/// A tile's error is no smaller than those below it, and its volume holds theirs.
void TilesetExport::gather() {
  for (auto at = tiles_.rbegin(); at != tiles_.rend(); ++at) {
    const auto& [level, x, y] = at->first;
    if (level == 0) continue;
    const auto parent = tiles_.find({level - 1, x / 2, y / 2});
    if (parent == tiles_.end()) continue;
    TileNote& note = parent->second;
    note.error_m = std::max(note.error_m, at->second.error_m);
    note.lowest_m = std::min(note.lowest_m, at->second.lowest_m);
    note.highest_m = std::max(note.highest_m, at->second.highest_m);
  }
}

/// The tiles that none above holds. Coarse tiles have no mesh where the ground lies between their vertices.
std::vector<GeographicTile> TilesetExport::roots() const {
  std::vector<GeographicTile> found;
  for (const auto& [key, note] : tiles_) {
    const auto& [level, x, y] = key;
    if (level == 0 || !tiles_.contains({level - 1, x / 2, y / 2})) found.push_back({level, x, y});
  }
  return found;
}

Json TilesetExport::node_of(const GeographicTile& tile) const {
  const TileNote& note = tiles_.at({tile.level, tile.x, tile.y});
  const TickRect rect = tile.rect();
  const LonLat low = place_of(rect.west, rect.south), high = place_of(rect.east, rect.north);
  constexpr double kRadian = std::numbers::pi / 180;
  return {{"boundingVolume",
           {{"region",
             {low.lon * kRadian, low.lat * kRadian, high.lon * kRadian, high.lat * kRadian, note.lowest_m,
              note.highest_m}}}},
          {"geometricError", note.error_m},
          {"refine", "REPLACE"}};
}

/// A file with some levels of tiles from these on, and the files that go on below them.
Status TilesetExport::write_tileset(const ExportFolder& folder, const std::vector<GeographicTile>& roots,
                                    const std::string& name, Json& file) const {
  const std::string up = name.find('/') == std::string::npos ? "" : "../../";
  std::vector<GeographicTile> others;
  const auto build = [&](const auto& self, const GeographicTile& tile, int left) -> Json {
    Json node = node_of(tile);
    const std::vector<GeographicTile> children = children_of(tile);
    if (left == 0 && !children.empty()) {
      others.push_back(tile);
      node["content"] = {{"uri", up + name_of(tile) + ".json"}};
      return node;
    }
    node["content"] = {{"uri", up + name_of(tile) + ".glb"}};
    for (const GeographicTile& child : children) node["children"].push_back(self(self, child, left - 1));
    return node;
  };
  Json tree = build(build, roots.front(), kLevelsOfFile);
  if (roots.size() > 1) {
    Json all = {{"boundingVolume", tree["boundingVolume"]}, {"geometricError", 0}, {"refine", "REPLACE"}};
    Json& region = all["boundingVolume"]["region"];
    others.clear();
    for (const GeographicTile& root : roots) {
      Json node = build(build, root, kLevelsOfFile);
      const Json& own = node["boundingVolume"]["region"];
      for (const std::size_t i : {0, 1, 4})
        region[i] = std::min(region[i].get<double>(), own[i].get<double>());
      for (const std::size_t i : {2, 3, 5})
        region[i] = std::max(region[i].get<double>(), own[i].get<double>());
      all["geometricError"] =
          std::max(all["geometricError"].get<double>(), node["geometricError"].get<double>());
      all["children"].push_back(std::move(node));
    }
    tree = std::move(all);
  }
  // What is missing where no tile is drawn: all of the relief, if that is more than the root's error.
  const Json& region = tree["boundingVolume"]["region"];
  const double relief = region[5].get<double>() - region[4].get<double>();
  file = {{"asset", kAsset},
          {"geometricError", std::max(relief, tree["geometricError"].get<double>())},
          {"root", tree}};
  if (auto status = folder.write(name, file.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
      !status)
    return status;
  for (const GeographicTile& other : others) {
    Json own;
    if (auto status = write_tileset(folder, {other}, name_of(other) + ".json", own); !status) return status;
  }
  return {};
}

/// The ground's tileset alone, or one that adds the objects to it.
Status TilesetExport::write_ground_and_objects(const ExportFolder& folder, const VerticalShift& shift,
                                               ExportReport& report) const {
  const auto objects = write_object_tileset(pack_, options_.region, shift, folder);
  if (!objects) return objects.error();
  Json ground;
  if (!*objects) return write_tileset(folder, roots(), kTilesetName, ground);
  if (auto status = write_tileset(folder, roots(), kGroundName, ground); !status) return status;
  const auto child = [](const Json& region, const Json& error, const char* uri) -> Json {
    return {{"boundingVolume", {{"region", region}}},
            {"geometricError", error},
            {"refine", "ADD"},
            {"content", {{"uri", uri}}}};
  };
  const Json& root = ground["root"];
  Json region = root["boundingVolume"]["region"];
  for (const std::size_t i : {0, 1, 4}) region[i] = std::min(region[i].get<double>(), (*objects)->region[i]);
  for (const std::size_t i : {2, 3, 5}) region[i] = std::max(region[i].get<double>(), (*objects)->region[i]);
  const double error = std::max(ground["geometricError"].get<double>(), (*objects)->error_m);
  const Json all = {
      {"asset", kAsset},
      {"geometricError", error},
      {"root",
       {{"boundingVolume", {{"region", region}}},
        {"geometricError", error},
        {"refine", "ADD"},
        {"children",
         Json::array({child(root["boundingVolume"]["region"], root["geometricError"], kGroundName),
                      child((*objects)->region, (*objects)->error_m, "objects/tileset.json")})}}}};
  report.notes.push_back(fmt::format("{} objects of {} models, {} bytes beside the textures.",
                                     (*objects)->objects, (*objects)->models, (*objects)->bytes));
  return folder.write(kTilesetName, all.dump(1) + "\n");
}

Result<ExportReport> TilesetExport::run() {
  if (options_.levels && options_.levels->coarsest != 0)
    return usage_error(fmt::format("levels: expected them from 0 on, found {} to {}",
                                   options_.levels->coarsest, options_.levels->finest));
  const auto datum = datum_of(pack_, options_);
  if (!datum) return datum.error();
  const auto shift =
      vertical_shift(*datum, options_.heights.value_or(ExportHeights::ellipsoidal), options_.geoid);
  if (!shift) return shift.error();
  const PackPatches patches(pack_, accuracy_.finest_error_m);
  const auto plan = plan_mesh_export(pack_, patches, accuracy_.finest_error_m, options_, *shift);
  if (!plan) return plan.error();
  auto folder = ExportFolder::begin(options_.target, mesh_export_identity("3dtiles", pack_, options_, *datum),
                                    options_.resume);
  if (!folder) return folder.error();
  units_ = plan->units();
  now_ = {"export", 0, units_.size(), 0};
  for (const std::string& line : folder->done())
    if (auto status = count(*plan, line); !status) return status.error();
  MetreTiles tiles = tiles_within_memory(pack_, options_, kThreadBytes);
  const QuantizedMeshSource source{*plan, patches, tiles, *shift};
  const Status made = make_mesh_units<MadeUnit>(
      units_, folder->done().size(), options_.threads, [&](const Unit& unit) { return make(source, unit); },
      [&](std::size_t i, MadeUnit&& unit) { return take(*plan, *folder, i, std::move(unit)); });
  if (!made) return made.error();
  if (tiles_.empty())
    return failed(pack_.path().string() + ": expected heights in the region, the pack has none");
  gather();
  ExportReport report;
  if (auto status = write_ground_and_objects(*folder, *shift, report); !status) return status.error();
  report.datum = shift->datum;
  for (const auto& [number, level] : levels_) report.levels.push_back(level);
  if (auto status = folder->finish(); !status) return status.error();
  return report;
}

Result<ExportReport> write(const PackReader& pack, const ExportOptions& options,
                           const ProgressCallback& progress) {
  if (!pack.levels(Layer::heights))
    return bad_data(pack.path().string() + ": expected height tiles, found none");
  return TilesetExport(pack, options, progress).run();
}

}  // namespace

extern const ExportFormat tiles_3d_exporter;
const ExportFormat tiles_3d_exporter{
    "3dtiles", "a folder of 3D Tiles 1.1 with tileset.json: glTF meshes, the imagery and the objects on them",
    write};

}  // namespace cairn
