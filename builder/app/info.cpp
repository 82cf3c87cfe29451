#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "builder/app/pack_metadata.h"
#include "builder/app/report_error.h"
#include "builder/app/verbs.h"
#include "cairn/remote_pack.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

struct InfoOptions {
  std::string pack;
  bool json = false;
};

/// The number at a key of an object that came from a file, or NaN.
double number(const Json& object, const char* key) {
  const bool there = object.is_object() && object.contains(key) && object.at(key).is_number();
  return there ? object.at(key).get<double>() : std::nan("");
}

void print_levels(const char* title, const Json& levels) {
  fmt::print("{}\n  {:>5} {:>9} {:>9} {:>14} {:>11} {:>12}\n", title, "level", "tiles", "constant", "bytes",
             "bits/sample", "max error m");
  for (const Json& level : levels) {
    fmt::print("  {:>5} {:>9} {:>9} {:>14} {:>11.3f} {:>12.3f}\n", level["level"].get<int>(),
               level["tiles"].get<std::uint64_t>(), level["constant_tiles"].get<std::uint64_t>(),
               level["bytes"].get<std::uint64_t>(), level["bits_per_sample"].get<double>(),
               level["max_error_m"].get<double>());
  }
}

void print_imagery(const Json& imagery) {
  fmt::print("imagery {}\n  {:>5} {:>9} {:>9} {:>14} {:>11} {:>12}\n", imagery["format"].dump(), "level",
             "tiles", "constant", "bytes", "bits/texel", "PSNR dB");
  for (const Json& level : imagery["levels"]) {
    fmt::print("  {:>5} {:>9} {:>9} {:>14} {:>11.3f} {:>12.3f}\n", level["level"].get<int>(),
               level["tiles"].get<std::uint64_t>(), level["constant_tiles"].get<std::uint64_t>(),
               level["bytes"].get<std::uint64_t>(), level["bits_per_sample"].get<double>(),
               number(level, "psnr_db"));
  }
}

void print_rqt(const Json& rqt) {
  fmt::print("rqt\n  {:>5} {:>9} {:>14} {:>11} {:>12} {:>12}\n", "level", "tiles", "bytes", "bits/sample",
             "tolerance m", "triangles");
  for (const Json& level : rqt["levels"]) {
    fmt::print("  {:>5} {:>9} {:>14} {:>11.3f} {:>12.3f} {:>12}\n", level["level"].get<int>(),
               level["tiles"].get<std::uint64_t>(), level["bytes"].get<std::uint64_t>(),
               level["bits_per_sample"].get<double>(), level["tolerance_m"].get<double>(),
               level["triangles"].get<std::uint64_t>());
  }
}

void print_objects(const Json& objects) {
  const auto count = objects["objects"].get<std::uint64_t>();
  fmt::print("objects {}, {:.2f} bytes per object\n  {:>5} {:>9} {:>9} {:>14} {:>12} {:>12}\n", count,
             objects["bytes"].get<double>() / static_cast<double>(std::max<std::uint64_t>(count, 1)), "level",
             "tiles", "empty", "bytes", "objects", "largest m");
  for (const Json& level : objects["levels"]) {
    fmt::print("  {:>5} {:>9} {:>9} {:>14} {:>12} {:>12.2f}\n", level["level"].get<int>(),
               level["tiles"].get<std::uint64_t>(), level["constant_tiles"].get<std::uint64_t>(),
               level["bytes"].get<std::uint64_t>(), level["objects"].get<std::uint64_t>(),
               level["largest_m"].get<double>());
  }
  if (const double left_out = number(objects, "left_out"); left_out > 0)
    fmt::print("  {:.0f} places left out, as there is no ground beneath them\n", left_out);
  if (objects["scattered"].is_number())
    fmt::print(
        "  {:.0f} of them scattered; {:.0f} more were where the ground is outside their rule's limits\n",
        number(objects, "scattered"), number(objects, "outside_limits"));
  if (!objects["models"].is_array()) return;
  fmt::print("models {}, {} bytes\n  {:>12} {:>9} {:>9} {:>6}  name\n", objects["models"].size(),
             objects["model_bytes"].get<std::uint64_t>(), "objects", "triangles", "vertices", "levels");
  for (const Json& model : objects["models"]) {
    const bool named = model.is_object() && model.contains("name") && model.at("name").is_string();
    fmt::print("  {:>12.0f} {:>9.0f} {:>9.0f} {:>6.0f}  {}\n", number(model, "objects"),
               number(model, "triangles"), number(model, "vertices"), number(model, "levels"),
               named ? model.at("name").get<std::string>() : "?");
  }
}

void print_accuracy(const Json& info) {
  const Json& a = info["accuracy"];
  if (!a.is_object()) return;
  const Json worst = a.contains("worst") ? a.at("worst") : Json();
  fmt::print(
      "post errors    {:.0f} posts: max {:.3f} m at {:.5f},{:.5f}; rms {:.3f}, p50 {:.3f}, p95 {:.3f}, p99 "
      "{:.3f}\n",
      number(a, "posts"), number(a, "max_m"), number(worst, "lon"), number(worst, "lat"), number(a, "rms_m"),
      number(a, "p50_m"), number(a, "p95_m"), number(a, "p99_m"));
}

void print_sources(const char* kind, const Json& sources) {
  if (!sources.is_array() || sources.empty()) return;
  fmt::print("{:<14} {}\n", kind, sources.size());
  for (const Json& source : sources) {
    const bool named = source.is_object() && source.contains("name") && source.at("name").is_string();
    fmt::print("  {}", named ? source.at("name").get<std::string>() : "?");
    if (const double won = number(source, "posts_used"); !std::isnan(won))
      fmt::print("  {:.0f} posts won", won);
    if (const double lost = number(source, "posts_lost"); lost > 0)
      fmt::print(", {:.0f} lost to other sources", lost);
    for (const char* key : {"crs", "vertical_crs", "unit"})
      if (named && source.contains(key) && source.at(key).is_string())
        fmt::print(", {}", source.at(key).get<std::string>());
    if (named && source.contains("overrides"))
      fmt::print(", told {}", source.at("overrides").dump(-1, ' ', false, Json::error_handler_t::replace));
    fmt::print("\n");
  }
}

void print_text(const PackReader& pack, const Json& info) {
  const PackHeader& header = pack.header();
  const Json& b = info["bounds"];
  fmt::print("{}\n", pack.path().string());
  fmt::print("format         {}, {} bytes, id {}\n", header.version, header.file_bytes(),
             to_string(header.id));
  fmt::print("tiles          {0}x{0} samples in steps of {1} m, vertical datum {2}\n", header.tile_size,
             header.quantum_m, header.datum_name());
  if (header.body != Body())
    fmt::print("body           {}, semi-axes {} m and {} m\n", header.body.name,
               header.body.shape.semi_major_m, header.body.shape.semi_minor_m);
  fmt::print("bounds         west {} south {} east {} north {}\n", number(b, "west"), number(b, "south"),
             number(b, "east"), number(b, "north"));
  if (!info["levels"].empty()) {
    fmt::print("error bound    every post within {} m", number(info, "error_bound_m"));
    if (info.contains("least_error_bound_m"))
      fmt::print(", those in fractions of a metre within {} m", number(info, "least_error_bound_m"));
    fmt::print("\n");
    print_accuracy(info);
    print_levels("heights", info["levels"]);
  }
  if (info.contains("imagery")) print_imagery(info["imagery"]);
  if (info.contains("rqt")) print_rqt(info["rqt"]);
  if (info.contains("objects")) print_objects(info["objects"]);
  print_sources("sources", info["sources"]);
  if (info.contains("imagery") && info["imagery"].contains("sources"))
    print_sources("images", info["imagery"]["sources"]);
}

int run_info(const InfoOptions& options) {
  const Result<PackReader> pack = open_pack(options.pack);
  if (!pack) return report_error(pack.error());
  const Result<nlohmann::json> metadata = parse_metadata(*pack);
  if (!metadata) return report_error(metadata.error());
  if (pack->levels(Layer::rqt) || pack->levels(Layer::objects)) {
    if (const Status status = pack->read_index(); !status) return report_error(status.error());
  }
  const Json info = describe_pack_file(*pack, *metadata);
  if (options.json) {
    fmt::print("{}\n", info.dump(2));
  } else {
    print_text(*pack, info);
  }
  return 0;
}

}  // namespace

void add_info(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<InfoOptions>();
  CLI::App* verb = app.add_subcommand("info", "Say what a pack holds: grid, levels, accuracy, sources");
  verb->add_option("PACK", options->pack, "The pack, or its http:// or https:// address")->required();
  verb->add_flag("--json", options->json, "Print JSON");
  verb->callback([options, &exit_code] { exit_code = run_info(*options); });
}

}  // namespace cairn
