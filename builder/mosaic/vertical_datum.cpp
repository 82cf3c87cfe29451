#include "builder/mosaic/vertical_datum.h"

#include <algorithm>

#include <fmt/format.h>

namespace cairn {
namespace {

// The first source that says something; where another one says something else, an error.
Result<const RasterInfo*> agreed(const RasterPool& pool) {
  const RasterInfo* first = nullptr;
  for (std::size_t s = 0; s < pool.size(); ++s) {
    const RasterInfo& info = pool.info(s);
    if (!info.vertical) continue;
    if (first == nullptr) first = &info;
    if (is_one_datum(*first->vertical, *info.vertical)) continue;
    return bad_data(fmt::format(
        "{}: vertical CRS: expected {} as in {}, found {}; heights of different datums make no one surface",
        info.path.string(), first->vertical->name, first->path.string(), info.vertical->name));
  }
  return first;
}

bool all_say(const RasterPool& pool) {
  for (std::size_t s = 0; s < pool.size(); ++s)
    if (!pool.info(s).vertical) return false;
  return pool.size() > 0;
}

Status check_geoid(const RasterPool& pool, std::optional<VerticalDatum> told) {
  for (std::size_t s = 0; s < pool.size(); ++s) {
    const auto& vertical = pool.info(s).vertical;
    const VerticalDatum datum = told.value_or(vertical ? vertical->datum : VerticalDatum::unknown);
    if (datum != VerticalDatum::ellipsoid) continue;
    return bad_data(fmt::format(
        "{}: vertical CRS: expected heights above a geoid, to which undulations are added, found heights "
        "above the ellipsoid ({})",
        pool.info(s).path.string(), told ? "as it is told" : vertical->name));
  }
  return {};
}

}  // namespace

std::string other_datum_of(const MosaicDatum& datum) {
  constexpr std::size_t kMostBytes = 39;
  if (datum.datum != VerticalDatum::unknown) return {};
  std::size_t bytes = std::min(datum.vertical_crs.size(), kMostBytes);
  const auto is_inside_character = [&](std::size_t at) {
    return at < datum.vertical_crs.size() &&
           (static_cast<unsigned char>(datum.vertical_crs[at]) & 0xC0) == 0x80;
  };
  while (bytes > 0 && is_inside_character(bytes)) --bytes;
  return datum.vertical_crs.substr(0, bytes);
}

Result<MosaicDatum> vertical_datum_of(const RasterPool& pool, std::optional<VerticalDatum> told,
                                      bool with_geoid) {
  if (with_geoid) {
    if (auto orthometric = check_geoid(pool, told); !orthometric) return orthometric.error();
  }
  MosaicDatum datum;
  if (told) {
    datum.datum = *told;
  } else {
    const auto source = agreed(pool);
    if (!source) return source.error();
    if (all_say(pool)) datum = {(*source)->vertical->datum, (*source)->vertical->name};
  }
  if (with_geoid) datum = {VerticalDatum::ellipsoid, ""};
  return datum;
}

}  // namespace cairn
