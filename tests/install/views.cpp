#include <array>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>

#include <cairn/pack_reader.h>
#include <cairn/terrain.h>

int main(int argc, char** argv) {
  if (argc != 4) return std::fprintf(stderr, "usage: views PACK LON LAT\n"), 2;
  auto opened = cairn::PackReader::open(argv[1]);
  if (!opened) return std::fprintf(stderr, "%s\n", opened.error().message.c_str()), 3;
  auto terrain = cairn::Terrain::open(std::make_shared<const cairn::PackReader>(std::move(*opened)));
  if (!terrain) return std::fprintf(stderr, "%s\n", terrain.error().message.c_str()), 2;

  // A window of 60 degrees, and a sight of 5 degrees that looks elsewhere.
  std::array<cairn::ViewState, 2> views;
  views[0].eye = views[1].eye = {std::stod(argv[2]), std::stod(argv[3])};
  views[0].height_m = views[1].height_m = 3000;
  views[0].pitch_deg = views[1].pitch_deg = -15;
  views[1].heading_deg = 120;
  views[1].fov_y_deg = 5;
  views[1].viewport_width_px = views[1].viewport_height_px = 512;

  const cairn::RenderList* list = &terrain->update(views, 0);
  while (!list->is_settled) {
    std::printf("showing %.1f px\n", list->error_px);
    std::this_thread::sleep_for(std::chrono::milliseconds(16));
    list = &terrain->update(views, 1.0 / 60);
  }
  std::array<int, 2> seen{};
  for (const cairn::RenderTile& tile : list->tiles) {
    for (std::size_t view = 0; view < views.size(); ++view) seen[view] += (tile.seen_by >> view & 1) != 0;
  }
  std::printf("%d and %d tiles, %.2f px\n", seen[0], seen[1], list->error_px);
}
