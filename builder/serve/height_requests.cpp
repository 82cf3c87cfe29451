#include "builder/serve/height_requests.h"

#include <charconv>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "cairn/pack_sampler.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostPlaces = 1000;
constexpr std::size_t kSamplerTiles = 8;

std::optional<double> number(std::string_view text) {
  double value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || read.ec != std::errc() || read.ptr != text.data() + text.size() ||
      !std::isfinite(value))
    return std::nullopt;
  return value;
}

/// Returns the numbers of a list with commas; nullopt where one is none, is beyond the limit or there are too
/// many.
std::optional<std::vector<double>> numbers(const HttpRequest& request, const char* name, double limit) {
  const auto found = request.query.find(name);
  if (found == request.query.end()) return std::nullopt;
  std::vector<double> out;
  std::string_view rest(found->second);
  while (true) {
    const std::size_t comma = rest.find(',');
    const auto value = number(rest.substr(0, comma));
    if (!value || std::abs(*value) > limit || out.size() == kMostPlaces) return std::nullopt;
    out.push_back(*value);
    if (comma == std::string_view::npos) return out;
    rest = rest.substr(comma + 1);
  }
}

/// A pack and its sampler, for one request.
struct Sampled {
  const std::string* name;
  std::shared_ptr<const OpenedPack> pack;
  PackSampler sampler;
};

Result<std::vector<Sampled>> samplers(const std::vector<ServedPack>& packs, const std::string* only) {
  std::vector<Sampled> out;
  for (const ServedPack& served : packs) {
    if (only != nullptr && served.name() != *only) continue;
    auto opened = served.now();
    if (!opened) return opened.error();
    PackSampler sampler((*opened)->reader, kSamplerTiles);
    out.push_back({&served.name(), std::move(*opened), std::move(sampler)});
  }
  return out;
}

Result<Json> height_json(LonLat place, std::vector<Sampled>& sampled) {
  Json json = {{"lon", place.lon}, {"lat", place.lat}, {"height", nullptr}};
  for (Sampled& one : sampled) {
    const auto height = one.sampler.height_at(place);
    if (!height) return height.error();
    if (!*height) continue;
    json["height"] = (*height)->metres;
    json["error_m"] = (*height)->error_m;
    json["level"] = (*height)->level;
    json["vertical_datum"] = one.pack->reader.header().datum_name();
    json["pack"] = *one.name;
    break;
  }
  return json;
}

}  // namespace

HttpAnswer answer_heights(const HttpRequest& request, const std::vector<ServedPack>& packs) {
  const auto lon = numbers(request, "lon", 1e6), lat = numbers(request, "lat", 90);
  if (!lon || !lat || lon->size() != lat->size())
    return error_answer(400,
                        "heights: expected lon and lat, as many of one as of the other and at most 1000, in "
                        "degrees, as in /heights?lon=8.5&lat=47.4");
  const auto named = request.query.find("pack");
  auto sampled = samplers(packs, named == request.query.end() ? nullptr : &named->second);
  if (!sampled) return error_answer(503, sampled.error().message);
  if (sampled->empty()) return error_answer(404, "pack: expected one that is served, found " + named->second);
  Json heights = Json::array();
  for (std::size_t i = 0; i < lon->size(); ++i) {
    auto json = height_json({(*lon)[i], (*lat)[i]}, *sampled);
    if (!json) return error_answer(500, json.error().message);
    heights.push_back(std::move(*json));
  }
  const Json& answer = heights.size() == 1 ? heights.front() : heights;
  return json_answer(answer.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace cairn
