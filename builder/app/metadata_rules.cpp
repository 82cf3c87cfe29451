#include "builder/app/metadata_rules.h"

#include <cmath>
#include <string>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "builder/app/pack_metadata.h"

namespace cairn {
namespace {

using nlohmann::json;

/// Collects findings about one JSON document; a pointer that is not there or of another type is one.
class JsonRules {
 public:
  JsonRules(const json& document, std::vector<Finding>& findings)
      : document_(document), findings_(findings) {}

  void add(std::string what) { findings_.push_back({"metadata", std::move(what)}); }

  const json* at(const char* pointer, json::value_t type) {
    const json::json_pointer path(pointer);
    if (!document_.contains(path)) {
      add(fmt::format("{}: expected {}, found nothing", pointer, json(type).type_name()));
      return nullptr;
    }
    const json& value = document_.at(path);
    const bool number = value.is_number() && type == json::value_t::number_float;
    if (number || value.type() == type) return &value;
    add(fmt::format("{}: expected {}, found {}", pointer, json(type).type_name(), value.type_name()));
    return nullptr;
  }

  void text_is(const char* pointer, const std::string& expected) {
    const json* value = at(pointer, json::value_t::string);
    if (value != nullptr && value->get<std::string>() != expected) {
      add(fmt::format("{}: expected {}, found {}", pointer, expected, value->get<std::string>()));
    }
  }

  /// NaN where there is no number.
  double number(const char* pointer) {
    const json* value = at(pointer, json::value_t::number_float);
    return value != nullptr ? value->get<double>() : std::nan("");
  }

  void number_is(const char* pointer, double expected) {
    const double found = number(pointer);
    if (!std::isnan(found) && found != expected)
      add(fmt::format("{}: expected {}, found {}", pointer, expected, found));
  }

 private:
  const json& document_;
  std::vector<Finding>& findings_;
};

void check_bounds(JsonRules& rules) {
  if (rules.at("/bounds", json::value_t::object) == nullptr) return;
  const double west = rules.number("/bounds/west"), east = rules.number("/bounds/east");
  const double south = rules.number("/bounds/south"), north = rules.number("/bounds/north");
  if (west > east || south > north || south < -90 || north > 90 || west < -180 || east - west > 360) {
    rules.add(
        fmt::format("/bounds: expected an area of the Earth, found {} {} {} {}", west, south, east, north));
  }
}

/// Below, `bound` is what the bake promised and the accuracy what it measured. An exceeded error bound is no
/// damage: a bake may have been told to allow it.
void check_accuracy(JsonRules& rules) {
  rules.number("/error_bound_m");
  if (rules.at("/accuracy", json::value_t::object) == nullptr) return;
  const double posts = rules.number("/accuracy/posts"), max = rules.number("/accuracy/max_m");
  const double rms = rules.number("/accuracy/rms_m"), p50 = rules.number("/accuracy/p50_m");
  const double p95 = rules.number("/accuracy/p95_m"), p99 = rules.number("/accuracy/p99_m");
  if (posts < 0 || rms < 0 || p50 < 0 || p50 > p95 || p95 > p99 || p99 > max || rms > max) {
    rules.add(fmt::format(
        "/accuracy: expected 0 <= p50 <= p95 <= p99 <= max and rms <= max, found {} {} {} {} and {}", p50,
        p95, p99, max, rms));
  }
  rules.number("/accuracy/worst/lon");
  rules.number("/accuracy/worst/lat");
}

void check_levels(JsonRules& rules, const PackReader& pack) {
  const json* levels = rules.at("/levels", json::value_t::array);
  if (levels == nullptr) return;
  const auto expected = summarise_levels(pack, Layer::heights);
  if (levels->size() != expected.size()) {
    rules.add(
        fmt::format("/levels: expected {} as the index has, found {}", expected.size(), levels->size()));
    return;
  }
  for (std::size_t i = 0; i < expected.size(); ++i) {
    rules.number_is(fmt::format("/levels/{}/level", i).c_str(), expected[i].level);
    rules.number_is(fmt::format("/levels/{}/max_error_m", i).c_str(), expected[i].max_error_m);
  }
}

void check_imagery(JsonRules& rules, const PackReader& pack) {
  rules.at("/imagery/format", json::value_t::string);
  rules.at("/imagery/sources", json::value_t::array);
  const json* levels = rules.at("/imagery/levels", json::value_t::array);
  if (levels == nullptr) return;
  const auto expected = summarise_levels(pack, Layer::imagery);
  if (levels->size() != expected.size()) {
    rules.add(fmt::format("/imagery/levels: expected {} as the index has, found {}", expected.size(),
                          levels->size()));
    return;
  }
  for (std::size_t i = 0; i < expected.size(); ++i) {
    rules.number_is(fmt::format("/imagery/levels/{}/level", i).c_str(), expected[i].level);
    rules.number_is(fmt::format("/imagery/levels/{}/tiles", i).c_str(),
                    static_cast<double>(expected[i].tiles));
    rules.number(fmt::format("/imagery/levels/{}/psnr_db", i).c_str());
  }
}

}  // namespace

std::vector<Finding> check_metadata_json(const PackReader& pack) {
  std::vector<Finding> findings;
  const Result<json> metadata = parse_metadata(pack);
  if (!metadata) {
    findings.push_back({"metadata", "expected a JSON object"});
    return findings;
  }
  JsonRules rules(*metadata, findings);
  rules.at("/cairn", json::value_t::string);
  rules.text_is("/vertical_datum", std::string(pack.header().datum_name()));
  rules.number_is("/grid/tile_size", pack.header().tile_size);
  check_bounds(rules);
  const bool imagery_alone = pack.levels(Layer::imagery) && !pack.levels(Layer::heights);
  if (!imagery_alone) {
    rules.number_is("/grid/quantum_m", pack.header().quantum_m);
    check_accuracy(rules);
  }
  check_levels(rules, pack);
  if (pack.levels(Layer::imagery)) check_imagery(rules, pack);
  rules.at("/sources", json::value_t::array);
  rules.at("/options", json::value_t::object);
  return findings;
}

}  // namespace cairn
