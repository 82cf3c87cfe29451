#include <cstdio>
#include <memory>
#include <string>

#include <cairn/enu_frame.h>
#include <cairn/ground_query.h>
#include <cairn/height_batch.h>

int main(int argc, char** argv) {
  if (argc != 4) return std::fprintf(stderr, "usage: query PACK LON LAT\n"), 2;
  auto opened = cairn::PackReader::open(argv[1]);
  if (!opened) return std::fprintf(stderr, "%s\n", opened.error().message.c_str()), 3;
  const auto pack = std::make_shared<const cairn::PackReader>(std::move(*opened));
  const cairn::LonLat place{std::stod(argv[2]), std::stod(argv[3])};

  // 1. Heights, while the program does something else.
  cairn::HeightBatches batches(pack);
  auto heights = batches.sample({place, {place.lon, place.lat + 0.01}});
  const auto sampled = heights.get();
  if (!sampled || !(*sampled)[0]) return std::fprintf(stderr, "no ground there\n"), 1;
  const double ground_m = (*sampled)[0]->metres;

  // 2. A point 1 km to the east and 300 m up, and the ray from there straight down.
  const cairn::EnuFrame frame({place, ground_m});
  const glm::dvec3 from = frame.to_geocentric({1000, 0, 300});
  cairn::GroundQuery query(pack);
  const auto hit = query.ray(from, frame.to_geocentric({1000, 0, 0}) - from);
  if (!hit) return std::fprintf(stderr, "%s\n", hit.error().message.c_str()), 3;
  if (*hit) std::printf("ground %.2f m below, at %.2f m\n", (*hit)->distance_m, (*hit)->at.height_m);

  // 3. Whether it is seen from a mast of 20 m at the place.
  const auto sight = query.line_of_sight({place, ground_m + 20}, frame.to_geodetic({1000, 0, 300}));
  if (!sight) return std::fprintf(stderr, "%s\n", sight.error().message.c_str()), 3;
  std::printf("%s by %.2f m, give or take %.2f m\n", sight->is_clear ? "clear" : "blocked",
              sight->clearance_m, sight->error_m);
}
