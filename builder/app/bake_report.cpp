#include "builder/app/bake_report.h"

#include <fstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "builder/app/pack_metadata.h"
#include "builder/bake/memory_budget.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMiB = 1048576.0;

Result<Json> report_json(const BuildReport& report, const BuildOptions& options) {
  const auto pack = PackReader::open(options.session.target);
  if (!pack) return pack.error();
  const auto metadata = parse_metadata(*pack);
  if (!metadata) return metadata.error();
  Json json = describe_pack_file(*pack, *metadata);
  json["seconds"] = report.seconds;
  json["samples"] = report.samples;
  json["texels"] = report.texels;
  json["samples_per_second"] = static_cast<double>(report.samples + report.texels) / report.seconds;
  json["peak_rss_mib"] = static_cast<double>(peak_resident_bytes()) / kMiB;
  json["threads"] = report.threads;
  json["resumed"] = report.resumed;
  json["within_error_bound"] = report.within_error_bound;
  json["options"] = metadata->at("options");
  return json;
}

void print_imagery(const Json& imagery) {
  for (const Json& level : imagery["levels"]) {
    fmt::print("level {:>3}: {:>7} textures, {:>3} constant, {:>10.2f} MiB, {:.2f} bits/texel, {:.2f} dB\n",
               level["level"].get<int>(), level["tiles"].get<std::uint64_t>(),
               level["constant_tiles"].get<std::uint64_t>(), level["bytes"].get<double>() / kMiB,
               level["bits_per_sample"].get<double>(), level["psnr_db"].get<double>());
  }
}

void print_table(const Json& r, const BuildOptions& options) {
  const Json& a = r["accuracy"];
  fmt::print("{}: {:.2f} MiB, {} samples, {} texels in {:.2f} s ({:.1f} M/s, {} threads, peak {:.0f} MiB)\n",
             options.session.target.string(), r["file_bytes"].get<double>() / kMiB,
             r["samples"].get<std::uint64_t>(), r["texels"].get<std::uint64_t>(), r["seconds"].get<double>(),
             r["samples_per_second"].get<double>() / 1e6, r["threads"].get<int>(),
             r["peak_rss_mib"].get<double>());
  if (a.is_object()) {
    fmt::print(
        "accuracy at {} posts: max {:.4g} m (bound {:.4g}{}), rms {:.4g}, p50 {:.4g}, p95 {:.4g}, p99 "
        "{:.4g}\n",
        a["posts"].get<std::uint64_t>(), a["max_m"].get<double>(), r["error_bound_m"].get<double>(),
        r.contains("least_error_bound_m")
            ? fmt::format("; {:.4g} of fractions", r["least_error_bound_m"].get<double>())
            : "",
        a["rms_m"].get<double>(), a["p50_m"].get<double>(), a["p95_m"].get<double>(),
        a["p99_m"].get<double>());
  }
  for (const Json& level : r["levels"]) {
    fmt::print(
        "level {:>3}: {:>7} tiles, {:>6} constant, {:>10.2f} MiB, {:.2f} bits/sample, error {:.4g} m\n",
        level["level"].get<int>(), level["tiles"].get<std::uint64_t>(),
        level["constant_tiles"].get<std::uint64_t>(), level["bytes"].get<double>() / kMiB,
        level["bits_per_sample"].get<double>(), level["max_error_m"].get<double>());
  }
  if (r.contains("imagery")) print_imagery(r["imagery"]);
  if (r.contains("objects"))
    fmt::print("{} objects of {} models, {:.2f} MiB, {:.2f} bytes per object\n",
               r["objects"]["objects"].get<std::uint64_t>(), r["objects"]["models"].size(),
               r["objects"]["bytes"].get<double>() / kMiB,
               r["objects"]["bytes"].get<double>() / r["objects"]["objects"].get<double>());
}

}  // namespace

void print_dry_run(const DryRun& dry, bool json) {
  Json out{{"tile_size", dry.tile_size}, {"top", dry.top},
           {"finest", dry.finest},       {"error_bound_m", dry.error_bound_m},
           {"quantum_m", dry.quantum_m}, {"samples", dry.samples}};
  Json levels = Json::array();
  for (const auto& [level, tiles] : dry.tiles) levels.push_back({{"level", level}, {"tiles", tiles}});
  out["levels"] = levels;
  Json textures = Json::array();
  for (const auto& [level, tiles] : dry.texture_tiles)
    textures.push_back({{"level", level}, {"tiles", tiles}});
  out["imagery_levels"] = textures;
  out["estimated_bytes"] = dry.estimated_bytes;
  out["estimated_seconds"] = dry.estimated_seconds;
  out["memory_bytes"] = dry.memory_bytes;
  if (json) {
    fmt::print("{}\n", out.dump(1, ' ', false, nlohmann::json::error_handler_t::replace));
    return;
  }
  for (const auto& [level, tiles] : dry.tiles) fmt::print("level {:>3}: {:>8} tiles at most\n", level, tiles);
  for (const auto& [level, tiles] : dry.texture_tiles)
    fmt::print("level {:>3}: {:>8} textures at most\n", level, tiles);
  if (!dry.tiles.empty())
    fmt::print("{} samples, error bound {:.4g} m in steps of {:.4g} m\n", dry.samples, dry.error_bound_m,
               dry.quantum_m);
  fmt::print("about {:.1f} MiB, {:.3g} s, under {:.0f} MiB of memory\n",
             static_cast<double>(dry.estimated_bytes) / kMiB, dry.estimated_seconds,
             static_cast<double>(dry.memory_bytes) / kMiB);
}

Status print_bake_report(const BuildReport& report, const BuildOptions& options, const std::string& file,
                         bool json) {
  const auto described = report_json(report, options);
  if (!described) return described.error();
  if (!file.empty()) {
    std::ofstream out(file);
    out << described->dump(1) << '\n';
    if (!out.flush()) return failed(file + ": report: expected to write it, found an unwritable file");
  }
  if (json) {
    fmt::print("{}\n", described->dump(1));
  } else {
    print_table(*described, options);
  }
  return {};
}

}  // namespace cairn
