#include "builder/export/region_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "builder/export/grid_error.h"
#include "builder/export/imagery_view.h"
#include "builder/export/pack_accuracy.h"
#include "builder/export/region_mesher.h"
#include "builder/export/region_raster.h"

namespace cairn {
namespace {

constexpr std::size_t kProgramBytes = std::size_t{64} << 20;
constexpr std::size_t kRegionTiles = 8;
constexpr std::size_t kSampleBytes = sizeof(float) + 1;
constexpr std::size_t kVertexBytes = 600;  // while the mesh is made and encoded
constexpr double kPackShare = 0.25;        // of the bound, what coarse tiles of the pack may be off
constexpr int kLeastTexture = 64, kMostTexture = 4096;
constexpr std::size_t kTextureBytes = std::size_t{kMostTexture} * kMostTexture * 8;

class RegionMeshMaker {
 public:
  RegionMeshMaker(const PackReader& pack, const ExportOptions& options, const ProgressCallback& progress)
      : pack_(pack),
        options_(options),
        progress_(progress),
        accuracy_(accuracy_of(pack)),
        patches_(pack, accuracy_.finest_error_m) {}

  Result<RegionMesh> make();

 private:
  Result<GeoBounds> region() const;
  Result<double> bound() const;
  Status add_texture(RegionMesh& mesh) const;
  Status go_on() {
    ++now_.done;
    now_.total = std::max(now_.total, now_.done);
    return progress_(now_) ? Status() : Status(failed("export: cancelled"));
  }

  const PackReader& pack_;
  const ExportOptions& options_;
  const ProgressCallback& progress_;
  PackAccuracy accuracy_;
  PackPatches patches_;
  Progress now_{"export", 0, 0, 0};
};

Result<GeoBounds> RegionMeshMaker::region() const {
  const auto region = options_.region ? options_.region : accuracy_.bounds;
  if (!region) return bad_data(pack_.path().string() + ": metadata: bounds: expected an area, found none");
  if (region->west >= -180 && region->east <= 180) return *region;
  return usage_error("region: expected one that keeps clear of the antimeridian, found another");
}

Result<double> RegionMeshMaker::bound() const {
  if (options_.max_error_m) return *options_.max_error_m;
  if (accuracy_.finest_error_m && *accuracy_.finest_error_m > 0) return 2 * *accuracy_.finest_error_m;
  return usage_error(
      "error: expected what the mesh may be off, since the pack does not say what its posts are, found none");
}

Status RegionMeshMaker::add_texture(RegionMesh& mesh) const {
  const auto levels = pack_.levels(Layer::imagery);
  if (!levels) return {};
  const double texels = std::ldexp(std::max(mesh.bounds.width(), mesh.bounds.height()), levels->finest) *
                        (pack_.header().tile_size - 1);
  int side = kLeastTexture;
  while (side < texels && side < kMostTexture) side *= 2;
  const auto view = draw_imagery(pack_, mesh.bounds, side);
  if (!view) return view.error();
  if (view->is_empty) return {};
  auto jpeg = encode_jpeg(*view);
  if (!jpeg) return jpeg.error();
  mesh.ground.jpeg = std::move(*jpeg);
  mesh.texture_side = side;
  return {};
}

Result<RegionMesh> RegionMeshMaker::make() {
  if (options_.levels)
    return usage_error("levels: expected none, since a mesh is as fine as its error asks for, found some");
  const auto datum = datum_of(pack_, options_);
  if (!datum) return datum.error();
  const auto shift =
      vertical_shift(*datum, options_.heights.value_or(ExportHeights::as_stored), options_.geoid);
  if (!shift) return shift.error();
  const auto area = region();
  if (!area) return area.error();
  const auto bound_m = bound();
  if (!bound_m) return bound_m.error();
  const LonLat centre{(area->west + area->east) / 2, (area->south + area->north) / 2};
  const LocalPlane plane(centre, pack_.header().body.shape);
  if (const auto rim = rim_on_plane(plane, *area); !rim) return rim.error();
  const bool has_imagery = pack_.levels(Layer::imagery).has_value();
  const std::size_t fixed = kProgramBytes + (has_imagery ? kTextureBytes : 0);
  if (options_.memory_bytes < fixed + kProgramBytes)
    return usage_error(fmt::format("memory: expected at least {} MiB, found {}",
                                   (fixed + kProgramBytes) >> 20, options_.memory_bytes >> 20));
  const std::size_t spare = options_.memory_bytes - fixed;
  MetreTiles tiles(pack_, kRegionTiles);
  const auto raster =
      region_raster(pack_, patches_, tiles, *shift, ticks_around(*area), kPackShare * *bound_m,
                    spare / 2 / kSampleBytes, [this] { return go_on(); });
  if (!raster) return raster.error();
  if (raster->samples.error_m >= *bound_m)
    return usage_error(fmt::format(
        "error: expected more than {:.3f} m, which the pack's surface may be off its posts there, "
        "found {:g} m",
        raster->samples.error_m, *bound_m));
  const std::size_t most = (spare - raster->samples.metres.size() * kSampleBytes) / kVertexBytes;
  auto made = mesh_region(*raster, plane, *bound_m, most, [this] { return go_on(); });
  if (!made) return made.error();
  const LonLat low = place_of(raster->rect.west, raster->rect.south),
               high = place_of(raster->rect.east, raster->rect.north);
  RegionMesh mesh{std::move(made->ground),
                  0,
                  plane,
                  {low.lon, low.lat, high.lon, high.lat},
                  raster->level,
                  shift->datum,
                  *bound_m,
                  made->max_error_m,
                  raster->has_voids};
  if (auto status = add_texture(mesh); !status) return status.error();
  if (mesh.ground.jpeg.empty()) mesh.ground.texture.clear();
  return mesh;
}

}  // namespace

Result<RegionMesh> make_region_mesh(const PackReader& pack, const ExportOptions& options,
                                    const ProgressCallback& progress) {
  if (!pack.levels(Layer::heights))
    return bad_data(pack.path().string() + ": expected height tiles, found none");
  return RegionMeshMaker(pack, options, progress).make();
}

std::string describe_region_mesh(const RegionMesh& mesh) {
  const LonLat centre = mesh.plane.centre();
  const nlohmann::ordered_json json = {
      {"centre", {{"lon", centre.lon}, {"lat", centre.lat}}},
      {"bounds", {mesh.bounds.west, mesh.bounds.south, mesh.bounds.east, mesh.bounds.north}},
      {"projection", mesh.plane.description()},
      {"axes", "x east, y up, z south, metres"},
      {"vertical_datum", to_string(mesh.datum)},
      {"bound_m", mesh.bound_m},
      {"max_error_m", mesh.max_error_m}};
  return json.dump();
}

ExportReport report_of(const RegionMesh& mesh, std::uint64_t bytes) {
  ExportReport report;
  report.datum = mesh.datum;
  report.levels.push_back({mesh.level, 1, bytes, mesh.ground.positions.size(), mesh.ground.triangles.size(),
                           mesh.bound_m, mesh.max_error_m, "mesh"});
  const LonLat centre = mesh.plane.centre();
  report.notes.push_back(
      fmt::format("x is east, y up, z south, in metres from {:.7g}, {:.7g} and above the datum.", centre.lon,
                  centre.lat));
  if (mesh.texture_side > 0)
    report.notes.push_back(fmt::format("The imagery is a JPEG of {0} x {0} pixels.", mesh.texture_side));
  if (mesh.has_voids) report.notes.push_back("The mesh is open where the pack has no height.");
  return report;
}

}  // namespace cairn
