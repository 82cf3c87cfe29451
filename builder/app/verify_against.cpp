#include "builder/app/verify_against.h"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/task_arena.h>

#include "builder/app/pack_metadata.h"
#include "builder/heights/measure_pack.h"
#include "builder/raster/expand_inputs.h"
#include "builder/raster/raster_source.h"

namespace cairn {
namespace {

using Json = nlohmann::json;

template <class T>
std::optional<T> optional_at(const Json& object, const char* key) {
  if (!object.contains(key) || !object.at(key).is_number()) return std::nullopt;
  return object.at(key).get<T>();
}

// The options that the bake had, from the metadata; check_metadata_json() has looked at the types.
BuildOptions options_of(const PackReader& pack, const Json& metadata) {
  BuildOptions options;
  const Json& baked = metadata.at("options");
  options.tile_size = pack.header().tile_size;
  options.level = optional_at<int>(baked, "level");
  options.top = optional_at<int>(baked, "top");
  options.max_error_m = optional_at<double>(baked, "max_error");
  options.quantum_m = optional_at<double>(baked, "quantum");
  if (baked.value("void", "fill") == "keep") options.voids = VoidMode::keep;
  if (baked.contains("region")) {
    const Json& r = baked.at("region");
    options.region = GeoBounds{r.value("west", -180.0), r.value("south", -90.0), r.value("east", 180.0),
                               r.value("north", 90.0)};
  }
  return options;
}

bool differ(double measured, double stated) {
  return std::abs(measured - stated) > 1e-9 * (1 + std::abs(stated));
}

}  // namespace

Result<std::vector<Finding>> verify_against(const PackReader& pack, const std::vector<std::string>& inputs,
                                            const std::string& geoid, int threads) {
  const auto metadata = parse_metadata(pack);
  if (!metadata) return metadata.error();
  BuildOptions options = options_of(pack, *metadata);
  options.threads = threads;
  if (!geoid.empty()) options.geoid = geoid;
  auto paths = expand_inputs(inputs);
  if (!paths) return paths.error();
  options.inputs = std::move(*paths);

  tbb::task_arena arena(threads);
  const auto measured = arena.execute([&] { return measure_pack(pack, options); });
  if (!measured) return measured.error();

  std::vector<Finding> findings;
  const Json& accuracy = metadata->at("accuracy");
  const double error_bound_m = metadata->at("error_bound_m").get<double>();
  if (measured->max() > error_bound_m) {
    findings.push_back(
        {"accuracy",
         fmt::format("expected every post within {} m, found {} m at lon {} lat {}", error_bound_m,
                     measured->max(), measured->worst().lon, measured->worst().lat)});
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
