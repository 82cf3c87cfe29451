#include "cairn/terrain.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>

#include <glm/geometric.hpp>

#include "cairn/geodesy.h"
#include "runtime/paging/pager.h"
#include "runtime/paging/tile_availability.h"
#include "runtime/scene/focus_tile.h"
#include "runtime/view/ground_height.h"
#include "runtime/view/motion_predictor.h"

namespace cairn {
namespace {

constexpr double kFarthest_m = 1e12;  // beyond, differences of positions lose what a pixel is

Error out_of_range(const char* option, const std::string& expected, const std::string& found) {
  return usage_error(std::string("terrain options: ") + option + ": expected " + expected + ", found " +
                     found);
}

Status check(const TerrainOptions& o, const TileAvailability& contents) {
  if (o.workers < 1 || o.workers > 64) {
    return out_of_range("workers", "1 to 64", std::to_string(o.workers));
  }
  if (o.pattern == RefinementPattern::nine || o.pattern == RefinementPattern::window) {
    return out_of_range("pattern", "one that covers the Earth", std::string(to_string(o.pattern)));
  }
  for (const double margin : {o.tile_margin, o.level_margin}) {
    if (!(margin >= 0 && margin < 1)) return out_of_range("margin", "0 to 1", std::to_string(margin));
  }
  if (!(o.look_ahead_s >= 0))
    return out_of_range("look_ahead_s", "0 or more", std::to_string(o.look_ahead_s));
  const std::uint64_t least = Pager::least_bytes(contents, o.workers);
  if (o.cache_bytes < least) {
    return out_of_range("cache_bytes", std::to_string(least) + " or more", std::to_string(o.cache_bytes));
  }
  return {};
}

Error bad_view(const char* what, const std::string& expected, double found) {
  return usage_error(std::string("view: ") + what + ": expected " + expected + ", found " +
                     std::to_string(found));
}

Status check(const ViewState& view, double dt_s) {
  struct Number {
    const char* name;
    double value;
  };
  for (const Number& number : {Number{"longitude", view.eye.lon}, Number{"latitude", view.eye.lat},
                               Number{"height", view.height_m}, Number{"heading", view.heading_deg},
                               Number{"pitch", view.pitch_deg}, Number{"roll", view.roll_deg}}) {
    if (!std::isfinite(number.value)) return bad_view(number.name, "a finite number", number.value);
  }
  if (std::abs(view.eye.lat) > 90) return bad_view("latitude", "-90 to 90", view.eye.lat);
  if (std::abs(view.height_m) > kFarthest_m) {
    return bad_view("height", std::to_string(kFarthest_m) + " m at most", view.height_m);
  }
  if (!(view.fov_y_deg > 0 && view.fov_y_deg < 180)) {
    return bad_view("field of view", "above 0 and below 180 degrees", view.fov_y_deg);
  }
  if (view.viewport_width_px < 1) return bad_view("viewport width", "1 or more", view.viewport_width_px);
  if (view.viewport_height_px < 1) return bad_view("viewport height", "1 or more", view.viewport_height_px);
  if (!(dt_s >= 0)) return bad_view("time since the last update", "0 or more", dt_s);
  return {};
}

}  // namespace

struct Terrain::State {
  State(std::shared_ptr<const PackReader> pack, const TerrainOptions& o, TileSource source)
      : options(o),
        contents(std::move(pack)),
        occluder(contents.lowest_m()),
        eye(o.tile_margin, o.level_margin),
        eye_ahead(o.tile_margin, o.level_margin),
        pager(contents, std::move(source), occluder, {o.cache_bytes, o.delivery_bytes, o.workers}) {
    list.lowest_m = contents.lowest_m();
  }

  TileId eye_tile_for(FocusTile& held, const ViewState& view) const;
  TileCut cover_for(const TileId& eye_tile) const;
  void add_to_cover(const TileId& area, bool has_source, TileCut& cover) const;
  void aim(const TileId& eye_tile);
  void look_ahead(const ViewState& view, double dt_s);
  std::size_t count_failing(const TileCut& cover) const;
  void list_tiles();
  void count_holes();
  const RenderList& refuse(const Error& error);

  const TerrainOptions options;
  TileAvailability contents;
  const Occluder occluder;
  FocusTile eye;
  FocusTile eye_ahead;
  MotionPredictor motion;
  std::optional<TileId> aimed_at;
  std::optional<TileId> looked_at;
  std::uint64_t availability_seen = 0;
  std::size_t failing = 0;  // tiles of the target that cannot be read at present
  bool view_refused = false;
  PagingStats counts;
  bool any_shown = false;
  RenderList list;
  Pager pager;
};

/// Measured from the highest ground that the eye's tile may have, from the index: what is loaded must not
/// decide the level.
TileId Terrain::State::eye_tile_for(FocusTile& held, const ViewState& view) const {
  const double above_ground_m = view.height_m - contents.ceiling_m(view.eye);
  const double ideal = level_for_pixel_size(view, above_ground_m, contents.pack().header().tile_size);
  return held.update(view.eye, ideal, kMinLevel, contents.levels().finest);
}

TileCut Terrain::State::cover_for(const TileId& eye_tile) const {
  const SceneMap map = build_scene_map({eye_tile, kMinLevel, options.pattern},
                                       [this](const TileId& id) { return contents.shows(id); });
  TileCut cover;
  cover.reserve(map.size());
  for (const SceneTile& tile : map) add_to_cover(tile.area, tile.has_source(), cover);
  std::sort(cover.begin(), cover.end(),
            [](const CutNode& a, const CutNode& b) { return depth_first_before(a.area, b.area); });
  return cover;
}

/// An area with nothing to show is split as far as needed for the coarsest tiles in it to show.
void Terrain::State::add_to_cover(const TileId& area, bool has_source, TileCut& cover) const {
  if (has_source || !contents.is_above_tiles(area)) {
    cover.push_back(make_cover_tile(area, contents, occluder, pager.target()));
    return;
  }
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const TileId child = child_of(area, quadrant);
    if (is_valid(child)) add_to_cover(child, contents.shows(child), cover);
  }
}

void Terrain::State::aim(const TileId& eye_tile) {
  if (aimed_at == eye_tile && availability_seen == pager.availability_version()) return;
  counts.moves += aimed_at != eye_tile;
  aimed_at = eye_tile;
  looked_at.reset();
  availability_seen = pager.availability_version();
  TileCut cover = cover_for(eye_tile);
  list.is_limited = !pager.fits(cover);
  for (TileId coarser = eye_tile; !pager.fits(cover) && coarser.level > kMinLevel;) {
    coarser = parent_of(coarser);
    cover = cover_for(coarser);
  }
  failing = count_failing(cover);
  pager.set_target(std::move(cover));
}

/// Of the tiles that cannot be read at present, those that an area of the cover would show.
std::size_t Terrain::State::count_failing(const TileCut& cover) const {
  const auto shows = [](const CutNode& node, const TileKey& key) {
    const TileId above = key.id.level > kMinLevel ? parent_of(key.id) : key.id;
    return node.area == above ||
           (node.area.level >= key.id.level && ancestor_of(node.area, key.id.level) == key.id);
  };
  const std::vector<TileKey> failing_tiles = contents.failing();
  return static_cast<std::size_t>(
      std::count_if(failing_tiles.begin(), failing_tiles.end(), [&](const TileKey& key) {
        return std::any_of(cover.begin(), cover.end(), [&](const CutNode& node) { return shows(node, key); });
      }));
}

void Terrain::State::look_ahead(const ViewState& view, double dt_s) {
  const double reach_m = 4 * tile_width_degrees(aimed_at->level) * kMeridianDegree_m;
  const ViewState there = motion.predict(view, dt_s, options.look_ahead_s, reach_m);
  const TileId tile = eye_tile_for(eye_ahead, there);
  if (looked_at == tile) return;
  looked_at = tile;
  std::vector<IndexEntry> ahead;
  if (tile != *aimed_at) {
    for (const CutNode& place : cover_for(tile)) {
      place.for_each_source([&](const IndexEntry& entry) { ahead.push_back(entry); });
    }
  }
  pager.set_ahead(std::move(ahead));
}

void Terrain::State::list_tiles() {
  list.version = pager.drawn_version();
  list.tiles.clear();
  for (const CutNode& place : pager.drawn()) {
    RenderTile tile;
    tile.area = tile.heights_id = tile.imagery_id = place.area;
    tile.volume = place.volume;
    if (place.heights) {
      tile.heights_id = place.heights->id;
      tile.geometric_error_m = place.heights->geometric_error_m;
      if (const LoadedTile* loaded = pager.find(*place.heights)) tile.heights = loaded->heights;
    }
    if (place.imagery) {
      tile.imagery_id = place.imagery->id;
      if (const LoadedTile* loaded = pager.find(*place.imagery)) tile.imagery = loaded->texture;
    }
    list.tiles.push_back(std::move(tile));
  }
  count_holes();
}

void Terrain::State::count_holes() {
  std::uint64_t holes = 0;
  for (const RenderTile& tile : list.tiles) {
    any_shown = any_shown || tile.heights;
    holes += !tile.heights && contents.nearest(Layer::heights, tile.area).has_value();
  }
  if (any_shown) counts.holes += holes;
}

/// The list of the last update, which a view that is out of range leaves as it was.
const RenderList& Terrain::State::refuse(const Error& error) {
  if (list.version != pager.drawn_version()) list_tiles();
  list.evicted.clear();
  list.errors.clear();
  if (!view_refused) list.errors.push_back(error);
  view_refused = true;
  list.is_complete = false;
  list.is_settled = true;
  return list;
}

Terrain::Terrain(std::unique_ptr<State> state) : state_(std::move(state)) {}
Terrain::Terrain(Terrain&&) noexcept = default;
Terrain& Terrain::operator=(Terrain&&) noexcept = default;
Terrain::~Terrain() = default;

Result<Terrain> Terrain::open(std::shared_ptr<const PackReader> pack, const TerrainOptions& options) {
  ReadTile read = read_from(pack);
  return open(std::move(pack), options, std::move(read));
}

Result<Terrain> Terrain::open(std::shared_ptr<const PackReader> pack, const TerrainOptions& options,
                              ReadTile read) {
  return open_source(std::move(pack), options, std::move(read));
}

Result<Terrain> Terrain::open(std::shared_ptr<const PackReader> pack, const TerrainOptions& options,
                              RequestTile request) {
  return open_source(std::move(pack), options, std::move(request));
}

Result<Terrain> Terrain::open_source(std::shared_ptr<const PackReader> pack, const TerrainOptions& options,
                                     TileSource source) {
  assert(pack != nullptr);
  if (const Status status = check(options, TileAvailability(pack)); !status) return status.error();
  return Terrain(std::make_unique<State>(std::move(pack), options, std::move(source)));
}

const RenderList& Terrain::update(const ViewState& view, double dt_s) {
  State& s = *state_;
  if (const Status status = check(view, dt_s); !status) return s.refuse(status.error());
  s.view_refused = false;
  s.aim(s.eye_tile_for(s.eye, view));  // 1. which map the eye wants
  s.look_ahead(view, dt_s);            // 2. which it may want next
  s.pager.advance();                   // 3. what has come in, replaces what it can
  if (s.list.version != s.pager.drawn_version()) s.list_tiles();
  const ViewFrustum volume(view, s.occluder);
  s.pager.request(volume);                 // 4. what is missing, asked for
  for (RenderTile& tile : s.list.tiles) {  // 5. what of the map can be seen
    tile.visible = volume.sees(tile.volume);
    tile.distance_m = tile.volume.distance_m(volume.eye());
  }
  s.list.is_complete = s.pager.is_settled() && s.failing == 0;
  s.list.is_settled = s.pager.is_settled() || s.pager.only_failing();
  s.list.evicted = s.pager.take_evicted();
  s.list.errors = s.pager.take_errors();
  ++s.counts.updates;
  s.counts.updates_behind += !s.list.is_complete;
  return s.list;
}

std::optional<double> Terrain::ground_height_m(LonLat place) const {
  for (const RenderTile& tile : state_->list.tiles) {
    if (tile_at(place, tile.area.level) != tile.area) continue;
    if (!tile.heights) return std::nullopt;
    return cairn::ground_height_m(*tile.heights, tile.heights_id, state_->contents.pack().header().quantum_m,
                                  place);
  }
  return std::nullopt;
}

TileId Terrain::eye_tile() const {
  return state_->aimed_at.value_or(TileId{kMinLevel, 0, 0});
}

PagingStats Terrain::stats() const {
  PagingStats stats = state_->counts;
  state_->pager.add_to(stats);
  return stats;
}

}  // namespace cairn
