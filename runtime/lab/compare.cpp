#include "runtime/lab/compare.h"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>

#include "runtime/lab/greedy_tin.h"
#include "runtime/lab/scene_use.h"
#include "runtime/view/cpu_clock.h"

namespace cairn {
namespace {

/// A contender at a tolerance, on its way along a flight.
struct Flyer {
  const Contender* contender = nullptr;
  double tolerance_px = 0;
  std::unique_ptr<LodMethod> lod;
  std::optional<PlacedMesh> before;
};

std::vector<Flyer> flyers_of(const CompareSpec& spec) {
  const double largest = *std::max_element(spec.tolerances_px.begin(), spec.tolerances_px.end());
  std::vector<Flyer> flyers;
  for (const double tolerance_px : spec.tolerances_px) {
    for (const Contender& contender : spec.contenders) {
      if (contender.method == lod_method("full") && tolerance_px < largest) continue;
      flyers.push_back({&contender, tolerance_px, contender.method->create(contender.options), {}});
    }
  }
  return flyers;
}

bool is_full(const Flyer& flyer) {
  return flyer.contender->method == lod_method("full");
}

void count_mesh(const LodMesh& mesh, FrameRecord& record) {
  record.triangles = mesh.triangle_count();
  for (const LodTileMesh& tile : mesh.tiles) record.vertices += tile.vertices.size();
  record.index_bytes = 12 * record.triangles;
  record.selection_ms = mesh.selection_s * 1e3;
  record.building_ms = mesh.building_s * 1e3;
  std::optional<IndexCount> least;
  for (const auto& form : mesh.forms) {
    if (form && (!least || form->indices < least->indices)) least = form;
  }
  if (least) record.strip_indices = least->indices, record.batches = least->parts;
}

void count_use(const SceneUse& use, const std::vector<TileId>& before, FrameRecord& record) {
  record.map_triangles = use.triangles;
  record.tiles = use.sources.size();
  record.new_tiles = difference(before, use.sources).size();
  record.useful_tiles = use.useful_tiles;
  record.resident_bytes = use.decoded_bytes;
  record.loaded_bytes = use.loaded_bytes;
  record.useful_loaded_bytes = use.useful_loaded_bytes;
}

/// One flight of all flyers.
class Race {
 public:
  Race(LabTerrain& terrain, const CameraPath& path, const CompareSpec& spec, const TakeRecord& take)
      : terrain_(terrain), path_(path), spec_(spec), take_(take), flyers_(flyers_of(spec)) {}

  Status fly() {
    terrain_.forget_eye();
    for (std::size_t frame = 0; frame < path_.views.size(); ++frame) {
      ViewState view = path_.views[frame];
      view.ellipsoid = terrain_.pack().header().body.shape;
      view.viewport_width_px = spec_.width_px;
      view.viewport_height_px = spec_.height_px;
      auto finest = FinestView::of(terrain_, view, spec_.threads);
      if (!finest) return finest.error();
      for (const double tolerance_px : spec_.tolerances_px) {
        if (const Status status = fly_tolerance(frame, view, *finest, tolerance_px); !status) return status;
      }
      finest_before_.emplace(std::move(*finest));
    }
    return {};
  }

 private:
  Status fly_tolerance(std::size_t frame, const ViewState& view, const FinestView& finest,
                       double tolerance_px) {
    SceneRules rules = spec_.tiles;
    rules.refine_px *= tolerance_px;
    const auto scene = terrain_.scene_for(view, rules);
    if (!scene) return scene.error();
    const SceneUse use = use_of(terrain_, *scene, view);
    std::vector<TileId>& before = sources_before_[tolerance_px];
    for (Flyer& flyer : flyers_) {
      if (flyer.tolerance_px != tolerance_px || (is_full(flyer) && frame > 0)) continue;
      FrameRecord record = new_record(frame, view);
      count_use(use, before, record);
      fly_one(*scene, view, finest, flyer, record);
      take_(record);
    }
    before = use.sources;
    return spec_.with_bound ? take_bound(frame, view, tolerance_px) : Status{};
  }

  FrameRecord new_record(std::size_t frame, const ViewState& view) const {
    FrameRecord record;
    record.flight = path_.name;
    record.frame = frame;
    record.pitch_deg = view.pitch_deg;
    return record;
  }

  Status take_bound(std::size_t frame, const ViewState& view, double tolerance_px) {
    const auto tin = greedy_tin(terrain_, view, tolerance_px);
    if (!tin) return tin.error();
    FrameRecord record = new_record(frame, view);
    record.method = "greedy-tin";
    record.tolerance_px = tolerance_px;
    record.triangles = tin->triangles;
    record.vertices = tin->vertices;
    record.error.max_px = tin->max_px;
    record.error.samples = tin->samples;
    record.keeps_tolerance = tin->max_px <= tolerance_px;
    take_(record);
    return {};
  }

  void fly_one(const LodScene& scene, const ViewState& view, const FinestView& finest, Flyer& flyer,
               FrameRecord& record) {
    record.method = flyer.contender->label;
    record.tolerance_px = flyer.tolerance_px;
    const double start = thread_cpu_s();
    flyer.lod->prepare(scene);
    record.preparing_ms = (thread_cpu_s() - start) * 1e3;
    record.resident_bytes += flyer.lod->prepared_bytes();
    LodMesh mesh = flyer.lod->build(scene, {view, flyer.tolerance_px, true});
    count_mesh(mesh, record);
    PlacedMesh now = place(scene, std::move(mesh), spec_.threads);
    record.joins = flyer.before.has_value();
    if (record.joins) {
      const FinestView::Before before{*flyer.before, *finest_before_};
      record.error = finest.measure(now, &before);
    } else {
      record.error = finest.measure(now, nullptr);
    }
    constexpr double kMeasureError_px = 1e-3;
    record.keeps_tolerance =
        record.error.max_px <= flyer.tolerance_px + kMeasureError_px && record.error.holes == 0;
    flyer.before = std::move(now);
    if (checks_faults(flyer, record.frame)) {
      record.faults = find_faults(scene, flyer.lod->build(scene, {view, flyer.tolerance_px, false}));
    }
  }

  /// Whole maps are large, and `full` makes the same grids everywhere.
  bool checks_faults(const Flyer& flyer, std::size_t frame) const {
    const double largest = *std::max_element(spec_.tolerances_px.begin(), spec_.tolerances_px.end());
    return frame == 0 && flyer.tolerance_px == largest && !is_full(flyer);
  }

  LabTerrain& terrain_;
  const CameraPath& path_;
  const CompareSpec& spec_;
  const TakeRecord& take_;
  std::vector<Flyer> flyers_;
  std::optional<FinestView> finest_before_;
  std::map<double, std::vector<TileId>> sources_before_;
};

}  // namespace

Status compare(LabTerrain& terrain, const CameraPath& path, const CompareSpec& spec, const TakeRecord& take) {
  return Race(terrain, path, spec, take).fly();
}

}  // namespace cairn
