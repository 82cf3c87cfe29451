// Between two frames no place of the drawn ground moves by more pixels than the tolerance, the camera's own
// motion apart: neither when grids change nor when tiles are exchanged for finer or coarser ones.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <thread>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"
#include "cairn/terrain.h"
#include "runtime/surface/lod_transition.h"
#include "tests/support/drawn_mesh.h"
#include "tests/support/gl_packs.h"
#include "tests/support/stage.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

constexpr double kTolerance_px = 1;
constexpr double kNoHurry = 1e9;  // frames that a level may take

/// What frames draw of a pack, worked out without a graphics context.
class Frames {
 public:
  Frames(const PackHeader& header, double longest_fade) : header_(header), longest_fade_(longest_fade) {}

  void frame(const RenderList& list, const ViewState& view) {
    view_ = view;
    const CameraFrame camera = camera_frame(view);
    const FrameScale scale{camera.position, 1 / pixel_footprint_m(view, 1), kTolerance_px, longest_fade_};
    shown_.update(list, scale, [this](const RenderTile& tile) { return surface_of(tile); });
    std::vector<SurfaceArea> areas;
    for (const ShownTile& shown : shown_.tiles()) {
      if (!shown.tile.visible) continue;
      areas.push_back({shown.tile.area, surface_of(shown.tile), shown.detail, shown.moves,
                       static_cast<double>(shown.tile.finer_error_m)});
    }
    SurfacePlan plan = plan_surface(areas, {view, kTolerance_px, std::min(list.lowest_m, 0.0), true});
    mesh_ = std::make_unique<DrawnMesh>(std::move(areas), std::move(plan));
  }
  /// As if tiles were exchanged at once.
  void cut() { shown_.cut(); }

  std::optional<double> height_m(LonLat place) const { return mesh_->height_m(place); }
  std::vector<double> heights_m(LonLat place) const { return mesh_->heights_m(place); }
  bool sees(LonLat place, double height_m) const {
    const PicturePoint at = project(view_, to_geocentric(place, height_m));
    return at.depth_m > 0 && at.x > 0 && at.y > 0 && at.x < view_.viewport_width_px &&
           at.y < view_.viewport_height_px;
  }
  /// By how many pixels, of the picture's middle, a difference in height moves what is seen of a place.
  double pixels(LonLat place, double height_m, double difference_m) const {
    const glm::dvec3 ray = to_geocentric(place, height_m) - camera_frame(view_).position;
    const double distance = glm::length(ray);
    const double across = glm::length(glm::cross(local_frame(place).up, ray / distance));
    return std::abs(difference_m) * across / pixel_footprint_m(view_, distance);
  }
  std::size_t moving() const {
    const auto tiles = shown_.tiles();
    return static_cast<std::size_t>(
        std::count_if(tiles.begin(), tiles.end(), [](const ShownTile& t) { return t.moves; }));
  }

 private:
  const SurfaceTile* surface_of(const RenderTile& tile) {
    if (!tile.heights) return nullptr;
    auto& surface = surfaces_[tile.heights_id];
    if (!surface) {
      surface = std::make_unique<SurfaceTile>(
          prepare_surface_tile(tile.heights_id, tile.heights, header_.quantum_m, false, {}));
    }
    return surface.get();
  }

  PackHeader header_;
  double longest_fade_;
  std::map<TileId, std::unique_ptr<SurfaceTile>> surfaces_;
  LodTransition shown_;
  ViewState view_;
  std::unique_ptr<DrawnMesh> mesh_;
};

enum class Exchange { smooth, abrupt };
enum class Tiles { in_time, late };

/// How long a tile takes to be read: time, and frames of the flight.
struct Delay {
  int ms = 0;
  int frames = 0;
};

/// A flight over a pack whose tiles take so long to read.
class Flight {
 public:
  Flight(const std::filesystem::path& path, Delay delay) {
    Result<PackReader> reader = PackReader::open(path);
    REQUIRE(reader.ok());
    const auto pack = std::make_shared<const PackReader>(std::move(*reader));
    frames_ = std::make_unique<Frames>(pack->header(), kNoHurry);
    const ReadTile read = read_from(pack);
    Result<Terrain> terrain = Terrain::open(pack, {}, [this, read, delay](const IndexEntry& entry) {
      std::this_thread::sleep_for(std::chrono::milliseconds(delay.ms));
      const int there = frames_drawn_ + delay.frames;
      while (!is_waiting_ && frames_drawn_ < there) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      return read(entry);
    });
    REQUIRE(terrain.ok());
    terrain_ = std::make_unique<Terrain>(std::move(*terrain));
  }

  Flight(const Flight&) = delete;
  Flight& operator=(const Flight&) = delete;
  ~Flight() {
    is_waiting_ = true;
    terrain_.reset();  // its readers look at the frames drawn
  }

  /// Lets tiles come until all are there.
  void wait(const ViewState& view) {
    is_waiting_ = true;
    while (!terrain_->update(view, 0).is_complete) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    is_waiting_ = false;
  }
  void frame(const ViewState& view, Exchange exchange) {
    if (exchange == Exchange::abrupt) frames_->cut();
    frames_->frame(terrain_->update(view, 1 / 30.0), view);
    tiles_moved_ += frames_->moving();
    ++frames_drawn_;
  }
  const Frames& frames() const { return *frames_; }
  std::size_t tiles_moved() const { return tiles_moved_; }

 private:
  std::atomic<int> frames_drawn_ = 0;
  std::atomic<bool> is_waiting_ = false;  // for tiles: they come without a delay of frames
  std::unique_ptr<Frames> frames_;
  std::unique_ptr<Terrain> terrain_;
  std::size_t tiles_moved_ = 0;
};

ViewState wide_view(LonLat eye, double height_m, double heading_deg, double pitch_deg) {
  ViewState view = view_at(eye, height_m, heading_deg, pitch_deg);
  view.viewport_width_px = 1280;
  view.viewport_height_px = 720;
  return view;
}

/// Down towards a place, low over it, and up again, looking ahead.
std::vector<ViewState> pass_over(LonLat place, double ground_m) {
  std::vector<ViewState> path;
  for (int i = 0; i < 300; ++i) {
    const double part = i / 300.0, high = std::abs(2 * part - 1.2);
    path.push_back(wide_view({place.lon - 0.25 + 0.5 * part, place.lat - 0.1 + 0.1 * part},
                             ground_m + 400 + 60000 * std::pow(high, 3), 60 + 30 * part,
                             -15 - 30 * std::min(high, 1.0)));
  }
  return path;
}

/// From high to low above a place, and a rest there.
std::vector<ViewState> dive_to(LonLat place, double ground_m) {
  std::vector<ViewState> path;
  for (int i = 0; i < 300; ++i) {
    const double left = std::max(0.0, 1 - i / 200.0);
    path.push_back(wide_view({place.lon - 1.5 * left, place.lat - left},
                             ground_m + 1000 + 1e6 * std::pow(left, 3), 30, -60 + 25 * (1 - left)));
  }
  return path;
}

/// Places in the picture's direction, near ones as many as far ones.
std::vector<LonLat> places_before(const ViewState& view, std::mt19937& random) {
  std::uniform_real_distribution<double> aside(-40, 40),
      far(std::log(0.0005), std::log(std::clamp(view.height_m / 50000, 0.5, 5.0)));
  std::vector<LonLat> places;
  for (int i = 0; i < 1500; ++i) {
    const double angle = glm::radians(view.heading_deg + aside(random)), distance = std::exp(far(random));
    places.push_back({view.eye.lon + distance * std::sin(angle) / std::cos(glm::radians(view.eye.lat)),
                      view.eye.lat + distance * std::cos(angle)});
  }
  return places;
}

struct MotionPredictor {
  double worst_px = 0;
  std::size_t compared = 0;
};

/// The height at a place that the last frame shows; nullopt where its picture has it not.
std::optional<double> shown_height_m(const Flight& flight, LonLat place) {
  const auto height = flight.frames().height_m(place);
  return height && flight.frames().sees(place, *height) ? height : std::nullopt;
}

/// How far places that two frames show move between them.
MotionPredictor motion_of(Flight& flight, const std::vector<ViewState>& path, Tiles tiles,
                          Exchange exchange) {
  std::mt19937 random(11);
  MotionPredictor motion;
  flight.wait(path.front());
  flight.frame(path.front(), exchange);
  for (std::size_t i = 1; i < path.size(); ++i) {
    if (tiles == Tiles::in_time) flight.wait(path[i]);
    if (tiles == Tiles::late) std::this_thread::sleep_for(std::chrono::milliseconds(3));
    const std::vector<LonLat> places = places_before(path[i - 1], random);
    std::vector<std::optional<double>> before;
    for (const LonLat& place : places) before.push_back(shown_height_m(flight, place));
    flight.frame(path[i], exchange);
    for (std::size_t k = 0; k < places.size(); ++k) {
      const auto now = before[k] ? shown_height_m(flight, places[k]) : std::nullopt;
      if (!now) continue;
      ++motion.compared;
      motion.worst_px = std::max(motion.worst_px, flight.frames().pixels(places[k], *now, *now - *before[k]));
    }
  }
  INFO("worst motion between two frames: " << motion.worst_px << " px of " << motion.compared << " places");
  CHECK(motion.compared > 20000);
  if (exchange == Exchange::smooth) CHECK(motion.worst_px <= kTolerance_px);
  return motion;
}

constexpr Delay kInTime{};
constexpr Delay kLate{.ms = 60};
constexpr Delay kVeryLate{.frames = 15};  // half a second of the flight, however fast the machine is

void check_smooth(const std::filesystem::path& pack, LonLat place, double ground_m) {
  Flight pass(pack, kInTime);
  motion_of(pass, pass_over(place, ground_m), Tiles::in_time, Exchange::smooth);
  CHECK(pass.tiles_moved() > 0);
  Flight late(pack, kLate);
  motion_of(late, dive_to(place, ground_m), Tiles::late, Exchange::smooth);
  CHECK(late.tiles_moved() > 0);
}

}  // namespace

TEST_CASE(
    "no place moves by more than the tolerance between two frames, whether tiles come in time or late") {
  const TempDir dir;
  const auto pack = dir.path() / "a.cairn";
  SECTION("generated ridges") {
    write_ridge_pack(pack, 0, 0);
    check_smooth(pack, ridge_places()[0], 2000);
    // The measure sees what an exchange at once does to tiles that come late. (In time, all that is exchanged
    // keeps the tolerance, so that there is little to see.)
    Flight abrupt(pack, kVeryLate);
    CHECK(motion_of(abrupt, dive_to(ridge_places()[0], 2000), Tiles::late, Exchange::abrupt).worst_px > 2);
  }
  SECTION("Hawaii, DTED") {
    if (!bake_real_pack(pack, {"dted1/n19_w156_3arc_v2.dt1", "dted1/n20_w156_3arc_v2.dt1"})) return;
    check_smooth(pack, {-155.6, 19.9}, 3000);
  }
  SECTION("the Alps, SRTM") {
    if (!bake_real_pack(pack, {"geotiff/N46E008.tif"})) return;
    check_smooth(pack, {8.4, 46.5}, 3500);
  }
}

namespace {

/// By how many pixels a place of the picture is off the nearest triangle that the frames reckon there, or off
/// those on both sides of it, where it is of a wall.
struct Difference {
  double px = 0;
  bool on_wall = false;
};
Difference difference_of(const Frames& frames, const Geodetic& shown, double pixel_m) {
  const auto height = frames.height_m(shown.place);
  REQUIRE(height.has_value());
  double off = std::numeric_limits<double>::infinity();
  for (const double each : frames.heights_m(shown.place))
    off = std::min(off, frames.pixels(shown.place, each, each - shown.height_m));
  if (off < 0.05) return {off, false};
  double low = *height, high = *height;
  // A wall joins what lies right beside it; a pixel may show it from half a pixel off.
  for (const double aside : {0.2 / 111000, pixel_m / 2 / 111000}) {  // degrees
    for (const auto& [east, north] : {std::pair(-1, -1), {1, -1}, {-1, 1}, {1, 1}}) {
      const double lon = shown.place.lon + east * aside / std::cos(glm::radians(shown.place.lat));
      const double beside = frames.height_m({lon, shown.place.lat + north * aside}).value_or(*height);
      low = std::min(low, beside);
      high = std::max(high, beside);
    }
  }
  const double outside = shown.height_m - std::clamp(shown.height_m, low, high);
  return {frames.pixels(shown.place, *height, outside), true};
}

}  // namespace

TEST_CASE("the picture has what the exchange says that is drawn, without a hole") {
  const TempDir dir;
  const auto pack = dir.path() / "a.cairn";
  write_ridge_pack(pack, 0, 0);
  Stage stage(pack, 1280, 720);
  Frames frames(stage.scene().pack().header(), FrameScale().longest_fade);
  std::size_t compared = 0, on_walls = 0;
  double worst_px = 0;
  int moving_frames = 0;
  const auto path = dive_to(ridge_places()[0], 2000);
  for (std::size_t i = 0; i < path.size(); i += 3) {
    const ViewState& view = path[i];
    stage.scene().load_all(view);
    stage.draw_now(view, 0.1);
    frames.frame(*stage.scene().list(), view);
    if (frames.moving() == 0) continue;
    if (++moving_frames > 8) break;
    CHECK(stage.holes() == 0);
    const std::vector<float> depth = stage.target().read_depth();
    for (int y = 5; y < 720; y += 20) {
      for (int x = 5; x < 1280; x += 20) {
        const auto at = static_cast<double>(depth[static_cast<std::size_t>(y * 1280 + x)]);
        if (at == 0) continue;
        const Geodetic shown = to_geodetic(shown_at(view, x + 0.5, y + 0.5, at));
        const double pixel_m = pixel_footprint_m(
            view, glm::length(to_geocentric(shown.place, shown.height_m) - camera_frame(view).position));
        const Difference difference = difference_of(frames, shown, pixel_m);
        worst_px = std::max(worst_px, difference.px);
        on_walls += difference.on_wall ? 1 : 0;
        ++compared;
      }
    }
  }
  INFO("worst difference: " << worst_px << " px, " << on_walls << " of " << compared << " places on walls");
  CHECK(compared > 5000);
  CHECK(on_walls < compared / 500);
  CHECK(worst_px < 0.05);
}

}  // namespace cairn::test
