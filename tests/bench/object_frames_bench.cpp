// What objects cost a frame on the CPU, against how many there are. Hidden: scripts/bench_object_frames runs
// it.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

#include "runtime/gl/frame_target.h"
#include "runtime/gl/headless_context.h"
#include "runtime/view/cpu_clock.h"
#include "runtime/viewer/scene.h"
#include "tests/support/object_pack.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

constexpr LonLat kCell{10.5, 45.5};
constexpr int kFrames = 300;
constexpr double kFineObject_px = 0.45;  // more than 20,000 instances

/// Boxes of 5 to 25 m, of 30 models with 265 vertices each, all over a degree of hills.
void write_cell(const std::filesystem::path& path, std::size_t count) {
  std::mt19937 random(5);
  std::vector<ObjectModel> models;
  for (int i = 0; i < 30; ++i) {
    const float size_m = 5 + 0.7F * static_cast<float>(i);
    models.push_back(box_model("box " + std::to_string(i), size_m / 2, size_m,
                               {static_cast<std::uint8_t>(8 * i), 90, 60}, 6));
  }
  std::uniform_real_distribution<double> inside(-0.499, 0.499);
  std::vector<TestObject> objects(count);
  for (TestObject& object : objects) {
    object.place = {kCell.lon + inside(random), kCell.lat + inside(random)};
    object.placed.model = static_cast<std::uint16_t>(random() % models.size());
    object.placed.heading = static_cast<std::uint16_t>(random());
  }
  std::vector<TileId> tiles;
  for (std::int32_t y = 0; y < 8; ++y) {
    for (std::int32_t x = 0; x < 8; ++x) {
      const TileId corner = tile_at({10, 45}, 3);
      tiles.push_back({3, corner.x + x, corner.y + y});
    }
  }
  write_object_pack(path, {513, 3, hills, {}}, with_ancestors(tiles, -4), models, objects);
}

struct FrameTimes {
  std::vector<double> whole, core;

  static double at(std::vector<double> values, double part) {
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))];
  }
  static void print(const char* name, const std::vector<double>& values) {
    std::printf("  %-12s p50 %.2f  p95 %.2f  p99 %.2f  max %.2f\n", name, at(values, 0.5), at(values, 0.95),
                at(values, 0.99), at(values, 1));
  }
};

ViewState view_at(LonLat eye, double height_m) {
  ViewState view;
  view.eye = eye;
  view.height_m = height_m;
  view.heading_deg = 45;
  view.fov_y_deg = 45;
  view.viewport_width_px = 1920;
  view.viewport_height_px = 1080;
  return view;
}

/// A level flight over the middle of the cell, tiles waited for before the first frame only.
FrameTimes fly(viewer::Scene& scene, const viewer::FrameLook& look, const gl::FrameTarget& target,
               viewer::FrameCounts& most) {
  FrameTimes times;
  ViewState view = view_at({kCell.lon - 0.2, kCell.lat - 0.2}, 1500);
  view.pitch_deg = -8;
  scene.load_all(view);
  scene.draw_list(view, look, target.framebuffer());
  for (int i = 0; i < kFrames; ++i) {
    view.eye.lon += 0.4 / kFrames * 0.1;
    view.eye.lat += 0.4 / kFrames * 0.1;
    const double begin = thread_cpu_s();
    scene.update(view, 1.0 / 60);
    const double updated = thread_cpu_s();
    const viewer::FrameCounts counts = scene.draw_list(view, look, target.framebuffer());
    times.whole.push_back(1e3 * (thread_cpu_s() - begin));
    times.core.push_back(1e3 * (updated - begin));
    if (counts.objects >= most.objects) most = counts;
  }
  return times;
}

}  // namespace

TEST_CASE("frames against the number of objects") {
  const Result<gl::HeadlessContext> context = gl::HeadlessContext::create();
  REQUIRE(context.ok());
  const Result<gl::FrameTarget> target = gl::FrameTarget::create(1920, 1080);
  REQUIRE(target.ok());
  for (const std::size_t count :
       {std::size_t{0}, std::size_t{5160}, std::size_t{20000}, std::size_t{153816}}) {
    const TempDir dir;
    const auto path = dir.path() / "cell.cairn";
    write_cell(path, std::max<std::size_t>(count, 1));
    for (const double object_px : {2.0, 1.0, kFineObject_px}) {
      if (count < 153816 && object_px < 2) continue;
      viewer::Options options;
      options.pack = path;
      options.object_px = object_px;
      options.cache_mib = 256;
      Result<viewer::Scene> scene = viewer::Scene::open(options);
      REQUIRE(scene.ok());
      viewer::FrameLook look;
      look.draws = false;
      look.object_px = object_px;
      look.objects = count > 0;
      viewer::FrameCounts most;
      const FrameTimes times = fly(*scene, look, *target, most);
      std::printf(
          "%zu objects, larger than %g pixels: at most %zu in the picture, %zu of them billboards, %zu "
          "calls, "
          "%zu triangles\n",
          count, object_px, most.objects, most.billboards, most.object_calls, most.object_triangles);
      FrameTimes::print("whole frame", times.whole);
      FrameTimes::print("runtime core", times.core);
      if (count > 0) {
        const auto pack = PackReader::open(path);
        std::uint64_t bytes = 0;
        for (const PackLevel& level : pack->level_table()) {
          if (level.layer == Layer::objects) bytes += level.block_bytes;
        }
        std::printf("  %.2f bytes per object in the pack\n",
                    static_cast<double>(bytes) / static_cast<double>(count));
      }
    }
  }
}

TEST_CASE("a low flight over the densest cell") {
  const Result<gl::HeadlessContext> context = gl::HeadlessContext::create();
  REQUIRE(context.ok());
  const Result<gl::FrameTarget> target = gl::FrameTarget::create(1920, 1080);
  REQUIRE(target.ok());
  const TempDir dir;
  const auto path = dir.path() / "cell.cairn";
  write_cell(path, 153816);
  viewer::Options options;
  options.pack = path;
  options.cache_mib = 256;
  Result<viewer::Scene> scene = viewer::Scene::open(options);
  REQUIRE(scene.ok());
  viewer::FrameLook look;
  look.draws = false;
  ViewState view = view_at({kCell.lon - 0.25, kCell.lat - 0.25}, 0);
  view.pitch_deg = -4;
  view.height_m = 1500;
  scene->load_all(view);  // and the first frame makes the shaders
  scene->draw(view, 0, look, target->framebuffer());
  std::vector<double> loading, whole;
  std::uint64_t most_bytes = 0;
  constexpr int kLowFrames = 1800;  // 30 s at 210 m/s, 150 m above ground
  for (int i = 0; i < kLowFrames; ++i) {
    view.eye.lon += 0.04 / kLowFrames;
    view.eye.lat += 0.05 / kLowFrames;
    view.height_m = scene->ground_m(view.eye) + 150;
    const double begin = thread_cpu_s();
    scene->update(view, 1.0 / 60);
    const double updated = thread_cpu_s();
    const viewer::FrameCounts counts = scene->draw_list(view, look, target->framebuffer());
    loading.push_back(1e3 * (updated - begin) + counts.upload_ms);
    whole.push_back(1e3 * (thread_cpu_s() - begin));
    most_bytes = std::max(most_bytes, scene->terrain().stats().resident_bytes);
  }
  const PagingStats stats = scene->terrain().stats();
  scene->load_all(view);
  scene->cut();
  const std::size_t settled = scene->draw(view, 0, look, target->framebuffer()).objects;
  Result<viewer::Scene> fresh = viewer::Scene::open(options);
  REQUIRE(fresh.ok());
  fresh->load_all(view);
  const std::size_t expected = fresh->draw(view, 0, look, target->framebuffer()).objects;
  const auto slow = std::count_if(loading.begin(), loading.end(), [](double ms) { return ms > 4; });
  std::printf("low flight, 153816 objects, %d frames: %lld frames above 4 ms of loading work\n", kLowFrames,
              static_cast<long long>(slow));
  FrameTimes::print("loading", loading);
  FrameTimes::print("whole frame", whole);
  std::printf("  at most %.1f MiB in memory; settled: %zu objects, a fresh scene %zu; holes %llu\n",
              static_cast<double>(most_bytes) / (1 << 20), settled, expected,
              static_cast<unsigned long long>(stats.holes));
  CHECK(settled == expected);
}

}  // namespace cairn::test
