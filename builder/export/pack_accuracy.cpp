#include "builder/export/pack_accuracy.h"

#include <algorithm>
#include <span>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "format/checksum.h"

namespace cairn {

using nlohmann::json;

PackAccuracy accuracy_of(const PackReader& pack) {
  const json metadata = json::parse(pack.metadata_json(), nullptr, false);
  PackAccuracy out;
  if (!metadata.is_object()) return out;
  const auto number = [&](const char* place) -> std::optional<double> {
    const json::json_pointer pointer(place);
    if (!metadata.contains(pointer) || !metadata.at(pointer).is_number()) return std::nullopt;
    return metadata.at(pointer).get<double>();
  };
  const auto bound = number("/error_bound_m"), measured = number("/accuracy/max_m");
  if (bound && measured) out.finest_error_m = std::max(*bound, *measured);
  const auto west = number("/bounds/west"), south = number("/bounds/south"), east = number("/bounds/east"),
             north = number("/bounds/north");
  if (west && south && east && north) out.bounds = GeoBounds{*west, *south, *east, *north};
  return out;
}

std::string identity_of(const PackReader& pack) {
  // The metadata has the hashes of all sources and every option that decides a byte.
  const std::string_view metadata = pack.metadata_json();
  return fmt::format("{:016x}", checksum(std::as_bytes(std::span(metadata.data(), metadata.size()))));
}

}  // namespace cairn
