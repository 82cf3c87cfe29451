#include "cairn/surface.h"

#include <algorithm>
#include <cmath>
#include <thread>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "runtime/surface/drawn_ground.h"
#include "runtime/surface/height_preparation.h"
#include "runtime/surface/lod_transition.h"
#include "runtime/surface/object_instances.h"
#include "runtime/surface/object_pick.h"
#include "runtime/surface/object_reach.h"
#include "runtime/surface/surface_plan.h"
#include "runtime/view/view_frustum.h"

namespace cairn {
namespace {

constexpr double kLongestFade_s = 2;  // that the exchange of a level takes at most

/// Half of the processors, but not so many that waking them takes longer than what they do.
int helping_threads() {
  return static_cast<int>(std::clamp(std::thread::hardware_concurrency() / 2, 1u, 4u));
}

}  // namespace

struct Surface::State {
  explicit State(const PackHeader& header) : quantum_m(header.quantum_m), ellipsoid(header.body.shape) {}

  double quantum_m;
  Ellipsoid ellipsoid;
  std::shared_ptr<PreparedHeights> prepared = std::make_shared<PreparedHeights>();
  LodTransition shown;
  std::unordered_map<TileId, SurfaceTile> tiles;
  std::vector<TileKey> evicted;  // and shown on, as far as is known
  ObjectArrivals arrivals;
  SurfaceMesher mesher{helping_threads()};
  SurfaceFrame frame;

  const SurfaceTile* tile_of(const RenderTile& tile);
  void note_evicted(const std::vector<TileKey>& keys);
  void release_unused();
};

const SurfaceTile* Surface::State::tile_of(const RenderTile& tile) {
  if (!tile.heights) return nullptr;
  const auto known = tiles.find(tile.heights_id);
  if (known != tiles.end()) return &known->second;
  PreparedHeightTile made = prepared->take(tile.heights_id, tile.heights, quantum_m, ellipsoid);
  frame.fresh.push_back(std::move(made.textures));
  return &tiles.emplace(tile.heights_id, std::move(made.surface)).first->second;
}

void Surface::State::note_evicted(const std::vector<TileKey>& keys) {
  for (const TileKey& key : keys) {
    if (key.layer == Layer::heights) prepared->forget(key.id);
    if (key.layer != Layer::objects) evicted.push_back(key);
  }
}

void Surface::State::release_unused() {
  if (evicted.empty()) return;
  std::unordered_set<TileKey> used;
  for (const ShownTile& each : shown.tiles()) {
    used.insert({Layer::heights, each.tile.heights_id});
    used.insert({Layer::imagery, each.tile.imagery_id});
  }
  std::erase_if(evicted, [&](const TileKey& key) {
    if (used.contains(key)) return false;
    if (key.layer == Layer::heights) tiles.erase(key.id);
    frame.released.push_back(key);
    return true;
  });
}

SurfaceWindow window_in(const TileId& tile, const TileId& patch) {
  const LatticePoint p = south_west_of(patch), t = south_west_of(tile);
  const auto width = static_cast<double>(lattice_width(tile.level));
  return {{static_cast<double>(p.x - t.x) / width, static_cast<double>(p.y - t.y) / width},
          std::ldexp(1.0, tile.level - patch.level)};
}

Surface::Surface(const PackHeader& header) : state_(std::make_unique<State>(header)) {}
Surface::Surface(Surface&&) noexcept = default;
Surface& Surface::operator=(Surface&&) noexcept = default;
Surface::~Surface() = default;

ReadTile Surface::preparing(ReadTile read) const {
  return [prepared = state_->prepared, read = std::move(read), quantum_m = state_->quantum_m,
          ellipsoid = state_->ellipsoid](const IndexEntry& entry) {
    Result<LoadedTile> tile = read(entry);
    if (tile && tile->heights) prepared->add(entry.id, tile->heights, quantum_m, ellipsoid);
    return tile;
  };
}

const SurfaceFrame& Surface::frame(const RenderList& list, const SurfaceView& view) {
  State& s = *state_;
  s.frame = {};
  ViewState eye = view.view;
  eye.ellipsoid = s.ellipsoid;
  // 1. Which tiles are shown, and with how much detail each.
  FrameScale scale{camera_frame(eye).position, 1 / pixel_footprint_m(eye, 1), view.tolerance_px};
  if (view.frame_s > 0) scale.longest_fade = std::max(1.0, kLongestFade_s / view.frame_s);
  s.shown.update(list, scale, [&s](const RenderTile& tile) { return s.tile_of(tile); });
  s.note_evicted(list.evicted);
  s.release_unused();
  // 2. Their areas.
  std::vector<std::shared_ptr<const LoadedObjects>> objects = list.objects;
  objects.insert(objects.end(), view.added.begin(), view.added.end());
  const ObjectReach reach(objects);
  const ViewFrustum frustum(eye, Occluder(list.lowest_m, s.ellipsoid));
  std::vector<SurfaceArea> areas;
  for (const ShownTile& each : s.shown.tiles()) {
    const double reach_m = reach.of(each.tile.area);
    // Where there are no heights, what ends there may be seen though the ground is not: its walls are drawn
    // with it.
    const bool counts = each.tile.visible || !each.tile.heights ||
                        (reach_m > 0 && frustum.sees(grown(each.tile.volume, reach_m)));
    if (!counts) continue;
    areas.push_back({each.tile.area, s.tile_of(each.tile), each.detail, each.moves,
                     static_cast<double>(each.tile.finer_error_m), reach_m});
    s.frame.tiles.push_back(&each.tile);
  }
  // 3. Patches, and the triangles of those that are new.
  s.frame.mesh = s.mesher.frame(areas, {eye, view.tolerance_px, std::min(list.lowest_m, 0.0), true},
                                {objects, s.quantum_m, view.object_px});
  // 4. What stands on them.
  s.arrivals.update(list.objects, view.frame_s);
  s.frame.objects =
      object_instances(s.mesher.object_patches(), s.arrivals, {eye, view.tolerance_px / 2, view.object_px});
  return s.frame;
}

void Surface::skip(const RenderList& list) {
  state_->note_evicted(list.evicted);
}

void Surface::cut() {
  state_->shown.cut();
  state_->arrivals.cut();
}

std::optional<ObjectHit> Surface::pick(const glm::dvec3& origin, const glm::dvec3& direction) const {
  return pick_object(state_->mesher.object_patches(), state_->ellipsoid, origin, direction);
}

std::optional<double> Surface::ground_m(LonLat place) const {
  return drawn_ground_m(state_->shown.tiles(), state_->quantum_m, place);
}

}  // namespace cairn
