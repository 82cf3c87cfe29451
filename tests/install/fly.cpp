#include <cairn/pack_reader.h>
#include <cairn/terrain.h>

#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>

int main(int argc, char** argv) {
  if (argc != 4) return std::fprintf(stderr, "usage: fly PACK LON LAT\n"), 2;
  auto opened = cairn::PackReader::open(argv[1]);
  if (!opened) return std::fprintf(stderr, "%s\n", opened.error().message.c_str()), 3;
  const auto pack = std::make_shared<const cairn::PackReader>(std::move(*opened));

  cairn::TerrainOptions options;
  options.cache_bytes = 256u << 20;
  auto terrain = cairn::Terrain::open(pack, options);
  if (!terrain) return std::fprintf(stderr, "%s\n", terrain.error().message.c_str()), 2;

  cairn::ViewState view;
  view.eye = {std::stod(argv[2]), std::stod(argv[3])};
  view.heading_deg = 90;
  view.pitch_deg = -10;
  for (int frame = 0; frame < 120; ++frame) {
    view.height_m = terrain->ground_height_m(view.eye).value_or(0) + 1500;  // both in the pack's datum
    view.eye.lon += 0.0002;  // about 18 m east

    const cairn::RenderList& list = terrain->update(view, 1.0 / 60);
    for (const cairn::Error& error : list.errors) std::fprintf(stderr, "%s\n", error.message.c_str());
    if (frame % 30 == 29) {
      int visible = 0;
      for (const cairn::RenderTile& tile : list.tiles) visible += tile.visible && tile.heights;
      std::printf("frame %d: %zu tiles, %d to draw%s\n", frame, list.tiles.size(), visible,
                  list.is_complete ? "" : ", more on the way");
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(16));
  }
  const cairn::PagingStats stats = terrain->stats();
  std::printf("%llu tiles loaded, latency p95 %.1f ms, holes %llu\n",
              static_cast<unsigned long long>(stats.tiles_loaded), stats.latency_ms.p95,
              static_cast<unsigned long long>(stats.holes));
}
