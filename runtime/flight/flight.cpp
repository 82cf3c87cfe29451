#include "runtime/flight/flight.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>

#include <nlohmann/json.hpp>

namespace cairn::viewer {
namespace {

using nlohmann::json;

std::optional<double> number(const json& object, const char* key) {
  const auto it = object.find(key);
  if (it == object.end() || !it->is_number()) return std::nullopt;
  return it->get<double>();
}

double turned(double from, double to, double part) {
  return from + std::remainder(to - from, 360.0) * part;
}

Result<FlightKey> key_from(const json& object, const std::string& place) {
  FlightKey key;
  const std::pair<const char*, double*> fields[] = {
      {"time", &key.time_s},          {"lon", &key.view.eye.lon},         {"lat", &key.view.eye.lat},
      {"height", &key.view.height_m}, {"heading", &key.view.heading_deg}, {"pitch", &key.view.pitch_deg}};
  for (const auto& [name, value] : fields) {
    const auto found = object.is_object() ? number(object, name) : std::nullopt;
    if (!found || !std::isfinite(*found))
      return bad_data(place + ": expected a number \"" + name + "\", found none");
    *value = *found;
  }
  if (std::abs(key.view.eye.lat) > 90 || std::abs(key.view.pitch_deg) > 90) {
    return bad_data(place + ": expected a latitude and a pitch within 90, found one outside");
  }
  return key;
}

}  // namespace

ViewState Flight::at(double time_s) const {
  if (time_s <= keys.front().time_s) return keys.front().view;
  const auto after =
      std::find_if(keys.begin(), keys.end(), [&](const FlightKey& k) { return k.time_s > time_s; });
  if (after == keys.end()) return keys.back().view;
  const FlightKey& a = *std::prev(after);
  const FlightKey& b = *after;
  const double part = (time_s - a.time_s) / (b.time_s - a.time_s);
  ViewState view = a.view;
  view.eye = {turned(a.view.eye.lon, b.view.eye.lon, part), std::lerp(a.view.eye.lat, b.view.eye.lat, part)};
  const double floor = std::min(a.view.height_m, b.view.height_m) - 1;
  view.height_m =
      floor + std::exp(std::lerp(std::log(a.view.height_m - floor), std::log(b.view.height_m - floor), part));
  view.heading_deg = turned(a.view.heading_deg, b.view.heading_deg, part);
  view.pitch_deg = std::lerp(a.view.pitch_deg, b.view.pitch_deg, part);
  return view;
}

std::size_t Flight::frame_count() const {
  return static_cast<std::size_t>(std::floor(keys.back().time_s * frames_per_second)) + 1;
}

Result<Flight> read_flight(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return failed(path.string() + ": flight: expected a file to read, found none");
  const std::string text(std::istreambuf_iterator<char>(in), {});
  const json root = json::parse(text, nullptr, false);
  const std::string place = path.string() + ": flight";
  if (!root.is_object()) return bad_data(place + ": expected a JSON object, found none");
  Flight flight;
  flight.frames_per_second = number(root, "frames_per_second").value_or(30);
  if (!(flight.frames_per_second > 0 && flight.frames_per_second <= 1000)) {
    return bad_data(place +
                    ": frames_per_second: expected more than 0 and 1000 at most, found another number");
  }
  const auto keys = root.find("keys");
  if (keys == root.end() || !keys->is_array() || keys->empty()) {
    return bad_data(place + ": expected an array \"keys\" with one key at least, found none");
  }
  for (const json& object : *keys) {
    const std::string key_place = place + ": key " + std::to_string(flight.keys.size());
    Result<FlightKey> key = key_from(object, key_place);
    if (!key) return key.error();
    const bool first = flight.keys.empty();
    if (first ? key->time_s != 0 : key->time_s <= flight.keys.back().time_s) {
      return bad_data(key_place + ": expected times that ascend from 0, found " +
                      std::to_string(key->time_s));
    }
    flight.keys.push_back(*key);
  }
  return flight;
}

std::string to_json(const Flight& flight) {
  json keys = json::array();
  for (const FlightKey& key : flight.keys) {
    keys.push_back({{"time", key.time_s},
                    {"lon", key.view.eye.lon},
                    {"lat", key.view.eye.lat},
                    {"height", key.view.height_m},
                    {"heading", key.view.heading_deg},
                    {"pitch", key.view.pitch_deg}});
  }
  return json{{"frames_per_second", flight.frames_per_second}, {"keys", keys}}.dump(1) + "\n";
}

}  // namespace cairn::viewer
