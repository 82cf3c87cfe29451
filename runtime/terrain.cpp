#include "cairn/terrain.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <glm/geometric.hpp>

#include "cairn/geodesy.h"
#include "runtime/paging/object_models.h"
#include "runtime/paging/object_selection.h"
#include "runtime/paging/pager.h"
#include "runtime/paging/tile_availability.h"
#include "runtime/paging/tile_selection.h"
#include "runtime/paging/tile_tree.h"
#include "runtime/scene/focus_tile.h"
#include "runtime/view/ground_height.h"
#include "runtime/view/motion_predictor.h"

namespace cairn {
namespace {

constexpr std::size_t kMostViews = 64;
constexpr std::uint64_t kUpdatesPerLookAhead = 8;
constexpr std::uint64_t kObjectsShare = 4;  // of the budget, objects take a quarter at most
constexpr double kFarthest_m = 1e12;        // beyond, differences of positions lose what a pixel is

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
  for (const double limit : {o.tolerance_px, o.texel_px, o.object_px}) {
    if (!(limit > 0))
      return out_of_range("tolerance_px, texel_px and object_px", "above 0", std::to_string(limit));
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

Status check(const ViewState& view) {
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
  return {};
}

Status check(std::span<const ViewState> views, double dt_s) {
  if (views.empty() || views.size() > kMostViews) {
    return bad_view("number of views", "1 to " + std::to_string(kMostViews),
                    static_cast<double>(views.size()));
  }
  for (const ViewState& view : views) {
    if (const Status status = check(view); !status) return status;
  }
  if (!(dt_s >= 0)) return bad_view("time since the last update", "0 or more", dt_s);
  return {};
}

bool is_same_view(const ViewState& a, const ViewState& b) {
  return a.eye.lon == b.eye.lon && a.eye.lat == b.eye.lat && a.height_m == b.height_m &&
         a.heading_deg == b.heading_deg && a.pitch_deg == b.pitch_deg && a.roll_deg == b.roll_deg &&
         a.fov_y_deg == b.fov_y_deg && a.viewport_width_px == b.viewport_width_px &&
         a.viewport_height_px == b.viewport_height_px;
}

}  // namespace

struct Terrain::State {
  State(std::shared_ptr<const PackReader> pack, const TerrainOptions& o, TileSource source)
      : options(o),
        table(pack->header().tile_size),
        contents(std::move(pack), &table),
        occluder(contents.lowest_m(), contents.pack().header().body.shape),
        tree(contents, occluder),
        models(std::make_shared<ObjectModels>(contents.shared_pack())),
        pager(table, contents, tree, with_models(std::move(source), models),
              {o.cache_bytes, o.delivery_bytes, o.workers}) {
    list.lowest_m = contents.lowest_m();
    target.cut = {tree.node({kMinLevel, 0, 0}).best};
  }

  /// What one of the views keeps from update to update.
  struct Eye {
    explicit Eye(const TerrainOptions& o)
        : focus(o.tile_margin, o.level_margin), focus_ahead(o.tile_margin, o.level_margin) {}
    FocusTile focus;
    FocusTile focus_ahead;
    MotionPredictor motion;
  };

  SelectionRules rules() const;
  void retarget(std::span<const ViewState> views);
  void look_ahead(std::span<const ViewState> views, double dt_s);
  std::size_t count_failing(const TileCut& cover) const;
  void list_tiles();
  void list_objects();
  std::size_t objects_on_their_way() const;
  void measure_list();
  void count_holes();
  const RenderList& refuse(const Error& error);

  TerrainOptions options;
  TileTable table;
  TileAvailability contents;
  const Occluder occluder;
  TileTree tree;
  std::vector<Eye> eyes;
  std::vector<ViewState> seen_views;
  std::vector<SelectionView> selection_views;
  bool is_available_anew = false;  // what the pack can show has changed since the target was made
  PagerTarget target;
  std::size_t failing = 0;         // tiles of the target that cannot be read at present
  std::uint64_t object_bytes = 0;  // that the target's objects may take
  std::uint64_t updates_until_ahead = 0;
  bool view_refused = false;
  PagingStats counts;
  bool any_shown = false;
  RenderList list;
  std::vector<Shortfall> shortfalls;  // of the list's tiles
  std::shared_ptr<ObjectModels> models;
  Pager pager;
};

SelectionRules Terrain::State::rules() const {
  return {kTileShare * options.tolerance_px, options.texel_px, std::exp2(options.level_margin),
          pager.target_bytes() - object_bytes};
}

void Terrain::State::retarget(std::span<const ViewState> views) {
  while (eyes.size() < views.size()) eyes.emplace_back(options);
  if (std::equal(views.begin(), views.end(), seen_views.begin(), seen_views.end(), is_same_view) &&
      !is_available_anew)
    return;
  const bool is_remade = std::exchange(is_available_anew, false);
  if (is_remade) tree.forget();
  tree.trim();
  seen_views.assign(views.begin(), views.end());
  selection_views.clear();
  for (std::size_t i = 0; i < views.size(); ++i) {
    selection_views.push_back(selection_view(views[i], contents, occluder, options.pattern, eyes[i].focus));
  }
  ObjectSelection objects =
      select_objects(tree, selection_views, options.object_px, pager.target_bytes() / kObjectsShare);
  object_bytes = objects.bytes;
  TileSelection selection = select_tiles(tree, selection_views, rules(), target.cut);
  list.is_limited = selection.is_limited || objects.is_limited;
  failing = count_failing(selection.cut) + objects.absent;
  const auto is_same = [](const CutNode& a, const CutNode& b) { return a.shows_same(b); };
  const bool has_same_objects = objects.tiles == target.objects;
  target.objects = std::move(objects.tiles);
  if (!is_remade && has_same_objects &&
      std::equal(selection.cut.begin(), selection.cut.end(), target.cut.begin(), target.cut.end(), is_same))
    return;
  ++counts.moves;
  updates_until_ahead = 0;
  target.cut = std::move(selection.cut);
  ++target.version;
}

/// Of the tiles that cannot be read at present, those that an area of the cover would show.
std::size_t Terrain::State::count_failing(const TileCut& cover) const {
  const auto shows = [](const CutNode& node, const TileKey& key) {
    const TileId above = key.id.level > kMinLevel ? parent_of(key.id) : key.id;
    return node.area == above ||
           (node.area.level >= key.id.level && ancestor_of(node.area, key.id.level) == key.id);
  };
  const std::vector<TileKey> failing_tiles = table.failing();
  return static_cast<std::size_t>(
      std::count_if(failing_tiles.begin(), failing_tiles.end(), [&](const TileKey& key) {
        return std::any_of(cover.begin(), cover.end(), [&](const CutNode& node) { return shows(node, key); });
      }));
}

void Terrain::State::look_ahead(std::span<const ViewState> views, double dt_s) {
  std::vector<SelectionView> there;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double degree_m = views[i].ellipsoid.equator_degree_m();
    const double reach_m = 4 * tile_width_degrees(selection_views[i].eye_tile.level) * degree_m;
    const ViewState ahead = eyes[i].motion.predict(views[i], dt_s, options.look_ahead_s, reach_m);
    if (updates_until_ahead > 0) continue;
    there.push_back(selection_view(ahead, contents, occluder, options.pattern, eyes[i].focus_ahead));
  }
  if (updates_until_ahead > 0) {
    --updates_until_ahead;
    return;
  }
  updates_until_ahead = kUpdatesPerLookAhead;
  std::vector<IndexEntry> ahead;
  if (options.look_ahead_s > 0) {
    for (const CutNode& node : select_tiles(tree, there, rules(), target.cut).cut) {
      node.for_each_source([&](const IndexEntry& entry) { ahead.push_back(entry); });
    }
  }
  if (ahead == target.ahead) return;
  target.ahead = std::move(ahead);
  ++target.version;
}

void Terrain::State::list_tiles() {
  ++list.version;
  list.tiles.clear();
  shortfalls.clear();
  for (const CutNode& place : pager.drawn()) {
    RenderTile tile;
    tile.area = tile.heights_id = tile.imagery_id = place.area;
    tile.volume = place.volume;
    if (place.heights) {
      tile.heights_id = place.heights->id;
      tile.geometric_error_m = place.heights->geometric_error_m;
      if (const LoadedTile* loaded = table.find(key_of(*place.heights))) tile.heights = loaded->heights;
    }
    if (place.imagery) {
      tile.imagery_id = place.imagery->id;
      if (const LoadedTile* loaded = table.find(key_of(*place.imagery))) tile.imagery = loaded->texture;
    }
    const Shortfall shortfall = shortfall_of(tree, place);
    tile.finer_error_m = static_cast<float>(shortfall.heights_m);
    shortfalls.push_back(shortfall);
    list.tiles.push_back(std::move(tile));
  }
  count_holes();
}

/// Lists those of the needed objects that are in memory.
void Terrain::State::list_objects() {
  std::vector<std::shared_ptr<const LoadedObjects>> objects;
  for (const IndexEntry& entry : target.objects) {
    if (const LoadedTile* loaded = table.find(key_of(entry))) objects.push_back(loaded->standing);
  }
  if (objects == list.objects) return;
  list.objects = std::move(objects);
  ++list.version;
}

/// Of the needed tiles of objects; those for which there is no memory are not.
std::size_t Terrain::State::objects_on_their_way() const {
  return static_cast<std::size_t>(
      std::count_if(target.objects.begin(), target.objects.end(),
                    [this](const IndexEntry& entry) { return is_requested(table.state(key_of(entry))); }));
}

/// What can be seen of the list, and how good it is.
void Terrain::State::measure_list() {
  list.error_px = list.texel_px = 0;
  for (std::size_t i = 0; i < list.tiles.size(); ++i) {
    RenderTile& tile = list.tiles[i];
    tile.seen_by = 0;
    tile.distance_m = std::numeric_limits<double>::infinity();
    for (std::size_t v = 0; v < selection_views.size(); ++v) {
      const SelectionView& view = selection_views[v];
      tile.distance_m = std::min(tile.distance_m, tile.volume.distance_m(view.frustum.eye()));
      if (!view.frustum.sees(tile.volume)) continue;
      tile.seen_by |= std::uint64_t{1} << v;
      list.error_px = std::max(list.error_px, view.scale.error_px(tile.volume, shortfalls[i].heights_m));
      if (shortfalls[i].texel_m > 0) {
        list.texel_px = std::max(list.texel_px, view.scale.length_px(tile.volume, shortfalls[i].texel_m));
      }
    }
    tile.visible = tile.seen_by != 0;
    if (tile.visible)
      pager.drawn()[i].for_each_source([this](const IndexEntry& e) { table.note_seen(key_of(e)); });
  }
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
  if (list.tiles.empty()) list_tiles();
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
  return update(std::span(&view, 1), dt_s);
}

const RenderList& Terrain::update(std::span<const ViewState> asked, double dt_s) {
  State& s = *state_;
  if (const Status status = check(asked, dt_s); !status) return s.refuse(status.error());
  std::vector<ViewState> views(asked.begin(), asked.end());
  for (ViewState& view : views) view.ellipsoid = s.contents.pack().header().body.shape;
  s.view_refused = false;
  s.retarget(views);          // 1. which tiles the views need
  s.look_ahead(views, dt_s);  // 2. which they may need next
  std::vector<ViewFrustum> frusta;
  for (const SelectionView& view : s.selection_views) frusta.push_back(view.frustum);
  PagerChanges changes = s.pager.update(s.target, frusta, Pager::Clock::now(),
                                        s.models->counts().bytes);  // 3. what of it is there
  s.is_available_anew = changes.availability;
  if (changes.drawn || s.list.tiles.empty()) s.list_tiles();
  s.list_objects();
  s.measure_list();  // 4. what of it can be seen, and how well
  const bool is_drawn = s.pager.state() != PagerState::replacing && s.objects_on_their_way() == 0;
  s.list.is_complete = is_drawn && s.failing == 0;
  s.list.is_settled = is_drawn || s.pager.only_failing();
  s.list.evicted = std::move(changes.evicted);
  s.list.errors = std::move(changes.errors);
  ++s.counts.updates;
  s.counts.updates_behind += !s.list.is_complete;
  return s.list;
}

void Terrain::set_tolerance_px(double tolerance_px) {
  assert(tolerance_px > 0);
  if (state_->options.tolerance_px == tolerance_px) return;
  state_->options.tolerance_px = tolerance_px;
  state_->seen_views.clear();  // the next update selects anew
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
  return state_->selection_views.empty() ? TileId{kMinLevel, 0, 0} : state_->selection_views[0].eye_tile;
}

PagingStats Terrain::stats() const {
  PagingStats stats = state_->counts;
  state_->pager.add_to(stats);
  const ObjectModelCounts models = state_->models->counts();
  stats.models_resident = models.resident;
  stats.model_bytes = models.bytes;
  stats.models_loaded = models.loads;
  for (const auto& tile : state_->list.objects) stats.objects_resident += tile->all().size();
  return stats;
}

}  // namespace cairn
