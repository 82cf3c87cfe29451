#include "runtime/viewer/settings.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <system_error>

#include <nlohmann/json.hpp>

namespace cairn::viewer {
namespace {

using nlohmann::json;

constexpr double kMostContours_m = 1e5;

/// The settings that are numbers within a range.
template <class Visit>
void for_each_number(Options& o, const Visit& visit) {
  visit("imagery", o.imagery, 0.0, 1.0);
  visit("exposure", o.exposure_ev, -10.0, 10.0);
  visit("contours", o.contours_m, 0.0, kMostContours_m);
  visit("tolerance", o.tolerance_px, 0.01, 1000.0);
  visit("hour", o.hour, 0.0, 24.0);
}

template <class Visit>
void for_each_switch(Options& o, const Visit& visit) {
  visit("slopes", o.slopes);
  visit("no_shadows", o.no_shadows);
  visit("no_fog", o.no_fog);
}

}  // namespace

std::filesystem::path settings_path() {
  const char* config = std::getenv("XDG_CONFIG_HOME");
  if (config && *config) return std::filesystem::path(config) / "cairn" / "view.json";
  const char* home = std::getenv("HOME");
  if (home && *home) return std::filesystem::path(home) / ".config" / "cairn" / "view.json";
  return {};
}

Status read_settings(const std::filesystem::path& path, Options& options) {
  std::ifstream in(path, std::ios::binary);
  if (path.empty() || !in) return {};
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  const json root = json::parse(text, nullptr, false);
  if (!root.is_object()) return bad_data(path.string() + ": settings: expected a JSON object, found none");
  for_each_number(options, [&](const char* key, double& value, double least, double most) {
    const json kept = root.value(key, json());
    if (kept.is_number() && kept.get<double>() >= least && kept.get<double>() <= most) value = kept;
  });
  for_each_switch(options, [&](const char* key, bool& value) {
    if (const json kept = root.value(key, json()); kept.is_boolean()) value = kept;
  });
  if (const json kept = root.value("tint", json()); kept.is_string()) options.tint = kept;
  if (const json kept = root.value("sea", json()); kept.is_number()) options.sea_m = kept.get<double>();
  return {};
}

Status write_settings(const std::filesystem::path& path, const Options& options) {
  if (path.empty()) return {};
  json root = json::object();
  Options values = options;
  for_each_number(values, [&](const char* key, double& value, double, double) { root[key] = value; });
  for_each_switch(values, [&](const char* key, bool& value) { root[key] = value; });
  root["tint"] = options.tint;
  if (options.sea_m) root["sea"] = *options.sea_m;
  std::error_code none;
  std::filesystem::create_directories(path.parent_path(), none);
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out << root.dump(2) << '\n';
  if (out.flush()) return {};
  return failed(path.string() + ": settings: expected to write them, found that it cannot be");
}

}  // namespace cairn::viewer
