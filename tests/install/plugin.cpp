// A shared library with the runtime in it, as an engine's plug-in is.
#include <cairn/terrain.h>

#include <memory>
#include <utility>

extern "C" double ground_height_m(const char* path, double lon, double lat) {
  const auto pack = std::make_shared<const cairn::PackReader>(std::move(*cairn::PackReader::open(path)));
  const auto terrain = cairn::Terrain::open(pack);
  return terrain ? terrain->ground_height_m({lon, lat}).value_or(0) : 0;
}
