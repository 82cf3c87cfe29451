#include "builder/raster/source_overrides.h"

#include <fnmatch.h>

namespace cairn {
namespace {

template <class T>
void take(const std::optional<T>& from, std::optional<T>& to) {
  if (from) to = from;
}

}  // namespace

bool matches_glob(const std::filesystem::path& file, const std::string& glob) {
  return ::fnmatch(glob.c_str(), file.c_str(), 0) == 0 ||
         ::fnmatch(glob.c_str(), file.filename().c_str(), 0) == 0;
}

SourceOverrides overrides_of(const std::filesystem::path& source, std::span<const SourceRule> rules) {
  SourceOverrides all;
  for (const SourceRule& rule : rules) {
    if (!matches_glob(source, rule.glob)) continue;
    take(rule.overrides.band, all.band);
    take(rule.overrides.nodata, all.nodata);
    take(rule.overrides.scale, all.scale);
    take(rule.overrides.offset, all.offset);
    take(rule.overrides.unit, all.unit);
    take(rule.overrides.crs, all.crs);
    take(rule.overrides.body, all.body);
    take(rule.overrides.latitude, all.latitude);
    take(rule.overrides.longitude, all.longitude);
    take(rule.overrides.sea_clamp_m, all.sea_clamp_m);
    take(rule.overrides.black, all.black);
    take(rule.overrides.white, all.white);
    take(rule.overrides.priority, all.priority);
  }
  return all;
}

}  // namespace cairn
