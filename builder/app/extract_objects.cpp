#include "builder/app/extract_objects.h"

#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "builder/app/points_csv.h"

namespace cairn {
namespace {

bool lies_in(const std::optional<GeoBounds>& region, LonLat place) {
  if (!region) return true;
  const double turns = 360 * std::ceil((region->west - place.lon) / 360);
  return region->contains({place.lon + turns, place.lat});
}

Result<std::vector<std::string>> model_names(const PackReader& pack) {
  std::vector<std::string> names;
  for (std::size_t m = 0; m < pack.model_count(); ++m) {
    const auto model = pack.read_model(static_cast<std::uint32_t>(m));
    if (!model) return model.error();
    names.push_back(csv_field(model->name, ','));
  }
  return names;
}

}  // namespace

Result<std::uint64_t> extract_objects(const PackReader& pack, const std::optional<GeoBounds>& region,
                                      const std::filesystem::path& output) {
  if (!pack.levels(Layer::objects))
    return failed(pack.path().string() + ": objects: expected some, the pack has none");
  const auto names = model_names(pack);
  if (!names) return names.error();
  std::ofstream out(output, std::ios::binary);
  out << "lon,lat,model,heading,scale,height,mode\n";
  std::uint64_t written = 0;
  const double quantum = pack.header().quantum_m;
  for (std::size_t i = 0; i < pack.entry_count(); ++i) {
    const IndexEntry entry = pack.entry(i);
    if (entry.layer != Layer::objects) continue;
    const auto tile = pack.read_object_tile(entry);
    if (!tile) return tile.error();
    for (const PlacedObject& object : tile->objects) {
      const LonLat at = place_of(entry.id, object);
      if (!lies_in(region, at)) continue;
      if (object.model >= names->size())
        return bad_data(pack.path().string() + ": objects " + to_string(entry.id) +
                        ": expected models of the pack, found number " + std::to_string(object.model));
      out << fmt::format("{:.10f},{:.10f},{},{:.4f},{:.6f},{},ground\n", at.lon, at.lat,
                         (*names)[object.model], object.heading_degrees(), object.scale_factor(),
                         object.height_quanta * quantum);
      ++written;
    }
  }
  if (!out.flush()) return failed(output.string() + ": expected to write it, found an unwritable file");
  return written;
}

}  // namespace cairn
