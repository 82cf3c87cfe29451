#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "builder/app/bake_progress.h"
#include "builder/app/pack_diff.h"
#include "builder/app/report_error.h"
#include "builder/app/verbs.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

// The exit codes of diff(1).
constexpr int kEqual = 0;
constexpr int kDifferent = 1;
constexpr int kTrouble = 2;

struct DiffOptions {
  std::string a;
  std::string b;
  bool json = false;
};

const char* text_of(Presence presence) {
  return presence == Presence::both ? "both" : presence == Presence::only_a ? "a" : "b";
}

/// The largest difference of all tiles of heights; null where no height differs.
const TileDifference* worst_of(const PackDifference& difference) {
  const TileDifference* worst = nullptr;
  for (const TileDifference& tile : difference.tiles)
    if (tile.heights && tile.heights->samples > 0 && (!worst || tile.heights->max_m > worst->heights->max_m))
      worst = &tile;
  return worst;
}

Json values_json(const std::vector<ValueDifference>& values) {
  Json out = Json::array();
  for (const ValueDifference& value : values)
    out.push_back({{"key", value.key}, {"a", Json::parse(value.a)}, {"b", Json::parse(value.b)}});
  return out;
}

Json heights_json(const HeightDifference& d) {
  Json out = {{"max_m", d.max_m}, {"rms_m", d.rms_m}, {"samples", d.samples}};
  if (d.samples > 0)
    out["worst"] = {{"lon", d.worst.lon}, {"lat", d.worst.lat}, {"a_m", d.a_m}, {"b_m", d.b_m}};
  out["only_in_a"] = d.only_in_a;
  out["only_in_b"] = d.only_in_b;
  return out;
}

Json tile_json(const TileDifference& tile) {
  Json out = {{"layer", to_string(tile.layer)}, {"tile", to_string(tile.id)}, {"in", text_of(tile.presence)}};
  if (tile.heights) out["heights"] = heights_json(*tile.heights);
  if (tile.texels) out["texels"] = {{"max", tile.texels->max}, {"differing", tile.texels->texels}};
  if (tile.blocks_differ) out["blocks_differ"] = true;
  if (!tile.values.empty()) out["values"] = values_json(tile.values);
  return out;
}

void print_json(const DiffOptions& options, const PackDifference& difference) {
  Json out = {{"a", options.a},
              {"b", options.b},
              {"equal", difference.is_empty()},
              {"tiles_compared", difference.comparable}};
  out["header"] = values_json(difference.header);
  out["metadata"] = values_json(difference.metadata);
  out["layers"] = Json::array();
  for (const LayerDifference& layer : difference.layers) {
    out["layers"].push_back({{"layer", to_string(layer.layer)},
                             {"equal", layer.equal},
                             {"differing", layer.differing},
                             {"only_in_a", layer.only_a},
                             {"only_in_b", layer.only_b}});
  }
  if (const TileDifference* worst = worst_of(difference)) out["max_m"] = worst->heights->max_m;
  out["tiles"] = Json::array();
  for (const TileDifference& tile : difference.tiles) out["tiles"].push_back(tile_json(tile));
  fmt::print("{}\n", out.dump(2, ' ', false, Json::error_handler_t::replace));
}

std::string heights_text(const HeightDifference& d) {
  std::string text;
  if (d.samples > 0) {
    text = fmt::format(": {} samples differ, max {:.4f} m at {:.6f},{:.6f} ({:.4f}, {:.4f}), rms {:.4f} m",
                       d.samples, d.max_m, d.worst.lon, d.worst.lat, d.a_m, d.b_m, d.rms_m);
  }
  const char* separator = d.samples > 0 ? "; " : ": ";
  if (d.only_in_a > 0) {
    text += fmt::format("{}{} samples have a height in A only", separator, d.only_in_a);
    separator = "; ";
  }
  if (d.only_in_b > 0) text += fmt::format("{}{} samples have a height in B only", separator, d.only_in_b);
  return text;
}

void print_tile(const TileDifference& tile) {
  std::string text = fmt::format("{} {}", to_string(tile.layer), to_string(tile.id));
  if (tile.presence != Presence::both)
    text += tile.presence == Presence::only_a ? ": only in A" : ": only in B";
  if (tile.heights) {
    text += heights_text(*tile.heights);
  } else if (tile.layer == Layer::heights && tile.presence != Presence::both) {
    text += fmt::format(": {} has equal heights there from coarser tiles",
                        tile.presence == Presence::only_a ? "B" : "A");
  }
  if (tile.texels)
    text += fmt::format(": {} texels differ, max {} of 255", tile.texels->texels, tile.texels->max);
  if (tile.blocks_differ) text += ": blocks differ";
  for (const ValueDifference& value : tile.values)
    text += fmt::format(": {} {}, {}", value.key, value.a, value.b);
  fmt::print("{}\n", text);
}

void print_text(const PackDifference& difference) {
  for (const ValueDifference& value : difference.header)
    fmt::print("header {}: {}, {}\n", value.key, value.a, value.b);
  for (const ValueDifference& value : difference.metadata)
    fmt::print("metadata {}: {}, {}\n", value.key, value.a, value.b);
  for (const TileDifference& tile : difference.tiles) print_tile(tile);
  if (difference.is_empty()) return;
  if (!difference.comparable) fmt::print("tiles are not compared, since their sizes differ\n");
  for (const LayerDifference& layer : difference.layers) {
    fmt::print("{}: {} tiles equal, {} differ, {} only in A, {} only in B\n", to_string(layer.layer),
               layer.equal, layer.differing, layer.only_a, layer.only_b);
  }
  if (const TileDifference* worst = worst_of(difference)) {
    const HeightDifference& d = *worst->heights;
    fmt::print("largest difference {:.4f} m, in {} at {:.6f},{:.6f}\n", d.max_m, to_string(worst->id),
               d.worst.lon, d.worst.lat);
  }
}

int trouble(const Error& error) {
  return std::max(kTrouble, report_error(error));
}

int run_diff(const DiffOptions& options) {
  const Result<PackReader> a = PackReader::open(options.a), b = PackReader::open(options.b);
  if (!a) return trouble(a.error());
  if (!b) return trouble(b.error());
  for (const PackReader* pack : {&*a, &*b}) {
    if (const Status status = pack->read_index(); !status) return trouble(status.error());
  }
  Result<PackDifference> difference = [&] {
    BakeProgress progress;
    return diff_packs(*a, *b, [&](std::uint64_t done, std::uint64_t total) {
      progress.show({"diff", done, total, 0});
    });
  }();
  if (!difference) return trouble(difference.error());
  options.json ? print_json(options, *difference) : print_text(*difference);
  return difference->is_empty() ? kEqual : kDifferent;
}

}  // namespace

void add_diff(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<DiffOptions>();
  CLI::App* verb = app.add_subcommand("diff", "Say what differs between two packs, tile by tile, in metres");
  verb->add_option("A", options->a, "A pack")->required();
  verb->add_option("B", options->b, "The pack to compare it with")->required();
  verb->add_flag("--json", options->json, "Print JSON");
  verb->callback([options, &exit_code] { exit_code = run_diff(*options); });
}

}  // namespace cairn
