#include "builder/export/export_format.h"

#include <cmath>

#include <fmt/format.h>

namespace cairn {

Status check_body(const PackReader& pack) {
  const Body& body = pack.header().body;
  const Body earth;
  // Ellipsoids of the Earth differ by less; a sphere of its mean radius is off by 7 km.
  constexpr double kMost_m = 300;
  if (std::abs(body.semi_major_m - earth.semi_major_m) < kMost_m &&
      std::abs(body.semi_minor_m - earth.semi_minor_m) < kMost_m)
    return {};
  return usage_error(
      fmt::format("{}: body: expected the Earth, which the formats of exports are for, found {}",
                  pack.path().string(), body.name));
}

Result<VerticalDatum> datum_of(const PackReader& pack, const ExportOptions& options) {
  const VerticalDatum own = pack.header().vertical_datum;
  if (!options.datum || *options.datum == own) return own;
  const std::string& other = pack.header().other_datum;
  if (own == VerticalDatum::unknown && other.empty()) return *options.datum;
  return usage_error(pack.path().string() + ": vertical datum: expected " +
                     (other.empty() ? to_string(own) : other) + ", which the pack has, found " +
                     to_string(*options.datum));
}

}  // namespace cairn
