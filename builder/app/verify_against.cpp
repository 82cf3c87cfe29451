#include "builder/app/verify_against.h"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/task_arena.h>

#include "builder/app/bake_progress.h"
#include "builder/app/pack_metadata.h"
#include "builder/heights/measure_pack.h"
#include "builder/pack/options_json.h"
#include "builder/raster/expand_inputs.h"
#include "builder/raster/raster_source.h"

namespace cairn {
namespace {

using SortedJson = nlohmann::json;

bool differ(double measured, double stated) {
  return std::abs(measured - stated) > 1e-9 * (1 + std::abs(stated));
}

}  // namespace

Result<std::vector<Finding>> verify_against(const PackReader& pack, const std::vector<std::string>& inputs,
                                            const std::string& geoid, int threads) {
  const auto metadata = parse_metadata(pack);
  if (!metadata) return metadata.error();
  const nlohmann::json baked = metadata->value("options", nlohmann::json::object());
  auto options = from_json(baked);
  if (!options) return options.error();
  if (baked.value("geoid", false) != !geoid.empty()) {
    return usage_error(pack.path().string() + ": expected " + (geoid.empty() ? "the" : "no") +
                       " geoid, as the pack was baked, found " + (geoid.empty() ? "none" : "one"));
  }
  if (!geoid.empty()) options->mosaic.geoid = geoid;
  auto found = expand_inputs(inputs);
  if (!found) return found.error();
  options->mosaic.inputs = std::move(found->files);
  options->session.threads = threads;

  tbb::task_arena arena(threads);
  BakeProgress line;
  const ProgressCallback show = [&](const Progress& progress) {
    line.show(progress);
    return true;
  };
  const auto measured = arena.execute([&] {
    return measure_pack(pack, options->mosaic, options->heights, options->grid, options->session, show);
  });
  if (!measured) return measured.error();

  std::vector<Finding> findings;
  const SortedJson& accuracy = metadata->at("accuracy");
  if (const auto& excess = measured->excess()) {
    findings.push_back(
        {"accuracy", fmt::format("expected every post within {} m, found {} m at lon {} lat {}",
                                 excess->bound_m, excess->error_m, excess->place.lon, excess->place.lat)});
  }
  const auto compare = [&](const char* key, double value) {
    const double stated = accuracy.value(key, std::nan(""));
    if (!differ(value, stated)) return;
    findings.push_back(
        {"accuracy", fmt::format("{}: expected {} as the pack states, found {}", key, stated, value)});
  };
  compare("posts", static_cast<double>(measured->count()));
  compare("max_m", measured->max());
  compare("rms_m", measured->rms());
  return findings;
}

}  // namespace cairn
