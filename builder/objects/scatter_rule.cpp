#include "builder/objects/scatter_rule.h"

#include <charconv>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "builder/objects/object_place.h"

namespace cairn {
namespace {

constexpr double kMostPerHectare = 1e5;
constexpr double kMostSpacing = 1e4;
constexpr double kLargestShare = 0.98;  // of the density that the spacing allows
constexpr double kHectare = 1e4;        // in square metres

std::string_view without_spaces(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

Status check_order(const char* low_name, double low, const char* high_name, double high) {
  if (low <= high) return {};
  return bad_data(
      fmt::format("{}: expected at most {}, which is {}, found {}", low_name, high_name, high, low));
}

}  // namespace

Status set_models(std::string_view text, ScatterRule& rule) {
  rule.models.clear();
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    std::string_view name = without_spaces(text.substr(at, end - at));
    at = end + 1;
    ScatterRule::Share share;
    if (const std::size_t colon = name.rfind(':'); colon != std::string_view::npos) {
      const std::string_view number = without_spaces(name.substr(colon + 1));
      const auto [stop, error] = std::from_chars(number.data(), number.data() + number.size(), share.weight);
      if (error != std::errc() || stop != number.data() + number.size() ||
          !(share.weight > 0 && share.weight <= 1e6))
        return bad_data(
            fmt::format("model: expected a weight above 0 after the colon, found '{}'", name.substr(0, 40)));
      name = without_spaces(name.substr(0, colon));
    }
    if (name.empty())
      return bad_data(fmt::format("model: expected NAME[:WEIGHT],…, found '{}'", text.substr(0, 40)));
    share.model = name;
    rule.models.push_back(std::move(share));
  }
  return {};
}

Status check_rule(const ScatterRule& rule) {
  if (rule.models.empty()) return bad_data("model: expected NAME[:WEIGHT],…, found none");
  const GroundLimits& limits = rule.limits;
  if (!(rule.per_hectare > 0))
    return bad_data(
        fmt::format("density: expected objects per hectare, above 0, found {}", rule.per_hectare));
  if (auto status = check_range("density", rule.per_hectare, 0, kMostPerHectare); !status) return status;
  if (auto status = check_range("spacing", rule.spacing_m, 0, kMostSpacing); !status) return status;
  for (const auto& [name, scale] : {std::pair{"min_scale", rule.min_scale}, {"max_scale", rule.max_scale}}) {
    if (auto status = check_range(name, scale, kLeastScale, kMostScale); !status) return status;
  }
  if (auto status = check_range("heading", rule.heading_degrees.value_or(0), -3600, 3600); !status)
    return status;
  for (const auto& [name, slope] :
       {std::pair{"min_slope", limits.min_slope_deg}, {"max_slope", limits.max_slope_deg}}) {
    if (auto status = check_range(name, slope, 0, 90); !status) return status;
  }
  if (auto status = check_order("min_scale", rule.min_scale, "max_scale", rule.max_scale); !status)
    return status;
  if (auto status = check_order("min_slope", limits.min_slope_deg, "max_slope", limits.max_slope_deg);
      !status)
    return status;
  if (auto status = check_order("min_height", limits.min_height_m, "max_height", limits.max_height_m);
      !status)
    return status;
  const double most = kLargestShare * kHectare / (std::numbers::pi * rule.spacing_m * rule.spacing_m);
  if (rule.per_hectare <= most) return {};
  return bad_data(
      fmt::format("density: expected at most {:.4g} per hectare where the spacing is {} m, found {}", most,
                  rule.spacing_m, rule.per_hectare));
}

Status check_area(const ScatterArea& area) {
  for (const auto& ring : area.rings) {
    if (ring.size() < 3)
      return bad_data(fmt::format("coordinates: expected rings of 3 or more places, found {}", ring.size()));
    for (const LonLat& at : ring) {
      if (auto status = check_range("lon", at.lon, -360, 360); !status) return status;
      if (auto status = check_range("lat", at.lat, -90, 90); !status) return status;
    }
  }
  return check_rule(area.rule);
}

}  // namespace cairn
