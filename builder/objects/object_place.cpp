#include "builder/objects/object_place.h"

#include <string>

#include <fmt/format.h>

namespace cairn {

Status check_range(const char* what, double value, double low, double high) {
  if (value >= low && value <= high) return {};
  return bad_data(fmt::format("{}: expected {} to {}, found {}", what, low, high, value));
}

Status check_place(const ObjectPlace& place) {
  if (place.model.empty()) return bad_data("model: expected a name, found none");
  if (auto status = check_range("lon", place.at.lon, -360, 360); !status) return status;
  if (auto status = check_range("lat", place.at.lat, -90, 90); !status) return status;
  if (auto status = check_range("heading", place.heading_degrees, -3600, 3600); !status) return status;
  if (auto status = check_range("scale", place.scale, kLeastScale, kMostScale); !status) return status;
  return check_range("height", place.height_m, -100000, 100000);
}

Status set_mode(std::string_view word, ObjectPlace& place) {
  if (word != "ground" && word != "absolute")
    return bad_data(fmt::format("mode: expected ground or absolute, found '{}'", word.substr(0, 40)));
  place.is_absolute = word == "absolute";
  return {};
}

}  // namespace cairn
