#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <random>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "runtime/stats/adaptive_walk.h"
#include "runtime/stats/block_count.h"
#include "runtime/stats/draw_map.h"
#include "runtime/stats/pack_walk.h"
#include "runtime/stats/report.h"

namespace cairn {
namespace {

struct Options {
  std::string pattern = "all";
  int levels = 4;
  int window = 8;
  std::string walk = "random";
  std::size_t moves = 20;
  std::uint64_t seed = 1;
  bool exhaustive = false;
  std::filesystem::path pack;
  int workers = 2;
  std::size_t loading = 0;
  double tolerance_px = 1;
  std::uint64_t cache_mib = 0;
  std::filesystem::path json;
  std::filesystem::path csv;
  std::vector<std::string> draw;
};

void declare(CLI::App& app, Options& o) {
  app.add_option("--pattern", o.pattern,
                 "all, or one of normal, plus, cross, restricted, balanced, nine, window; with --pack also "
                 "adaptive, tiles selected by their error");
  app.add_option("--tolerance", o.tolerance_px, "adaptive: pixels of error")->check(CLI::Range(0.01, 1000.0));
  app.add_option("--cache", o.cache_mib, "adaptive: MiB of tiles in memory; 0 for no limit");
  app.add_option("--levels", o.levels, "K, the levels that are counted")->check(CLI::Range(2, 9));
  app.add_option("--window", o.window, "tiles along a side of the window pattern")->check(CLI::Range(1, 64));
  app.add_option("--walk", o.walk, "axis, diagonal, random, or a file with a line dx,dy a move");
  app.add_option("--moves", o.moves, "moves of the walk")->check(CLI::Range(1, 100000));
  app.add_option("--seed", o.seed, "of the walk");
  app.add_flag("--exhaustive", o.exhaustive, "every eye tile of a 2^(K+2) square and every move of the kind");
  app.add_option("--pack", o.pack,
                 "count over a pack's tiles, load each move's difference blocks and time it");
  app.add_option("--workers", o.workers, "threads that load")->check(CLI::Range(1, 64));
  app.add_option("--loading", o.loading, "with --pack: time the loading of 1 to N blocks instead; see --csv");
  app.add_option("--json", o.json, "write the report as JSON");
  app.add_option("--csv", o.csv, "write the counts of every move as CSV");
  app.add_option("--draw", o.draw, "X,Y OUT.svg: draw the map with the eye X,Y tiles from a coarse corner")
      ->expected(2);
}

Result<std::vector<RefinementPattern>> chosen_patterns(const std::string& word) {
  const auto all = all_refinement_patterns();
  if (word == "all") return std::vector<RefinementPattern>(all.begin(), all.end());
  if (word == "adaptive") return std::vector<RefinementPattern>();
  if (const auto pattern = refinement_pattern_from(word)) return std::vector<RefinementPattern>{*pattern};
  return usage_error("--pattern: expected all or a pattern's name, found " + word);
}

Result<std::vector<Move>> chosen_walk(const Options& o) {
  const auto kinds = moves_of_kind(o.walk);
  if (!kinds.empty()) return random_walk(kinds, o.moves, o.seed);
  if (o.exhaustive)
    return usage_error("--exhaustive: expected --walk axis, diagonal or random, found " + o.walk);
  return read_walk(o.walk);
}

/// A walk starts at a random tile of the pattern's period, so that no walk favours the coarsest borders.
TileId chosen_start(const Options& o) {
  if (o.exhaustive) return endless_world();
  std::mt19937_64 random(o.seed);
  const std::uint64_t period = std::uint64_t{1} << (o.levels + 2);
  const auto x = static_cast<std::int32_t>(random() % period);
  return neighbour_of(endless_world(), x, static_cast<std::int32_t>(random() % period));
}

Status write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) return failed(path.string() + ": cannot be written");
  return {};
}

Status draw(const Options& o, const std::vector<RefinementPattern>& patterns) {
  if (patterns.size() != 1) return usage_error("--draw: expected one --pattern, found " + o.pattern);
  int x = 0, y = 0;
  if (std::sscanf(o.draw[0].c_str(), "%d,%d", &x, &y) != 2) {
    return usage_error("--draw: expected X,Y, found " + o.draw[0]);
  }
  const TileId eye = neighbour_of(endless_world(), x, y);
  const SceneMap map = build_scene_map({eye, eye.level - o.levels + 1, patterns[0], o.window});
  const std::string title = std::string(to_string(patterns[0])) + ", " + std::to_string(o.levels) +
                            " levels: " + std::to_string(map.size()) + " tiles";
  return write_text(o.draw[1], draw_map(map, eye, title));
}

Status write_reports(const Options& o, const StatsReport& report) {
  std::cout << to_table(report);
  if (!o.json.empty()) {
    if (auto written = write_text(o.json, to_json(report)); !written) return written;
  }
  return o.csv.empty() ? Status{} : write_text(o.csv, to_csv(report));
}

Status count(const Options& o, const std::vector<RefinementPattern>& patterns) {
  const auto walk = chosen_walk(o);
  if (!walk) return walk.error();
  StatsReport report{o.levels, o.walk, o.seed, o.exhaustive, "", {}};
  for (const RefinementPattern pattern : patterns) {
    const CountSpec spec{chosen_start(o), o.levels, pattern, o.window, nullptr};
    report.patterns.push_back({pattern,
                               o.exhaustive ? count_exhaustively(spec, moves_of_kind(o.walk))
                                            : count_moves(shown_along(spec, *walk)),
                               {}});
  }
  return write_reports(o, report);
}

Result<std::shared_ptr<const PackReader>> open_pack(const Options& o) {
  if (o.exhaustive) return usage_error("--exhaustive: expected no --pack, found one");
  Result<PackReader> pack = PackReader::open(o.pack);
  if (!pack) return pack.error();
  if (const Status status = pack->read_index(); !status) return status.error();
  return std::make_shared<const PackReader>(std::move(*pack));
}

Status count_over_pack(const Options& o, const std::vector<RefinementPattern>& patterns,
                       const std::shared_ptr<const PackReader>& pack, TimedLoader& loader) {
  const HasTile has = [&pack](const TileId& id) { return pack->find_index(Layer::heights, id).has_value(); };
  const auto start = middle_tile(*pack);
  if (!start) return bad_data(o.pack.string() + ": expected tiles of heights, found none");
  const auto walk = chosen_walk(o);
  if (!walk) return walk.error();
  const std::vector<Move> inside = kept_inside(*walk, *start, has);
  StatsReport report{o.levels, o.walk, o.seed, false, o.pack.string(), {}};
  const auto add = [&](std::optional<RefinementPattern> pattern,
                       const std::vector<std::vector<TileId>>& shown, double error_px) -> Status {
    auto loads = load_walk(shown, *pack, loader);
    if (!loads) return loads.error();
    report.patterns.push_back({pattern, count_moves(shown), std::move(*loads), error_px});
    return {};
  };
  for (const RefinementPattern pattern : patterns) {
    const Status added = add(pattern, shown_along({*start, o.levels, pattern, o.window, has}, inside), 0);
    if (!added) return added;
  }
  if (o.pattern == "all" || o.pattern == "adaptive") {
    const AdaptiveWalk adaptive =
        walk_adaptively({*start, o.levels, o.tolerance_px, o.cache_mib << 20}, inside, pack);
    const Status added = add(std::nullopt, adaptive.tiles, adaptive.error_px);
    if (!added) return added;
  }
  return write_reports(o, report);
}

Status use_pack(const Options& o, const std::vector<RefinementPattern>& patterns) {
  const auto pack = open_pack(o);
  if (!pack) return pack.error();
  if (o.loading == 0) {
    TimedLoader loader(read_from(*pack), o.workers, (*pack)->header().tile_size);
    return count_over_pack(o, patterns, *pack, loader);
  }
  const auto times = time_loading(*pack, o.loading, o.workers);
  if (!times) return times.error();
  const std::string csv = to_csv(*times);
  std::cout << csv;
  return o.csv.empty() ? Status{} : write_text(o.csv, csv);
}

Status run_checked(const Options& o) {
  const auto patterns = chosen_patterns(o.pattern);
  if (!patterns) return patterns.error();
  if (!o.draw.empty()) return draw(o, *patterns);
  if (!o.pack.empty()) return use_pack(o, *patterns);
  if (o.loading > 0) return usage_error("--loading: expected --pack, found none");
  if (o.pattern == "adaptive") return usage_error("--pattern adaptive: expected --pack, found none");
  return count(o, *patterns);
}

int run(const Options& o) {
  const Status status = run_checked(o);
  if (status) return 0;
  std::cerr << "cairn-stats: " << status.error().message << "\n";
  return static_cast<int>(status.error().code);
}

}  // namespace
}  // namespace cairn

int main(int argc, char** argv) {
  CLI::App app("Counts the blocks of scene maps: totals, and what a move of the eye has to load.",
               "cairn-stats");
  cairn::Options options;
  cairn::declare(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::cerr << "cairn-stats: " << error.what() << "\n";
    return static_cast<int>(cairn::ErrorCode::usage);
  }
  return cairn::run(options);
}
