#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/paging/frame_stats.h"
#include "runtime/stats/block_count.h"

namespace cairn {

/// The cost of loading one move's difference blocks from a pack.
struct MoveLoad {
  double latency_ms = 0;    ///< from the request to the last block decoded
  std::uint64_t bytes = 0;  ///< of blocks, as stored
};

/// The counts of one pattern; with a pack, also one load per move.
struct PatternReport {
  std::optional<RefinementPattern> pattern;  ///< none: adaptive, tiles selected by their error
  std::vector<MoveCount> counts;
  std::vector<MoveLoad> loads;
  double error_px = 0;  ///< adaptive: the largest screen error of the heights in any view

  std::string_view name() const { return pattern ? to_string(*pattern) : "adaptive"; }
};

/// One run of cairn-stats.
struct StatsReport {
  int levels = 4;
  std::string walk;
  std::uint64_t seed = 0;
  bool exhaustive = false;
  std::string pack;  ///< empty for the endless world
  std::vector<PatternReport> patterns;
};

/// Returns the report as JSON; docs/block-counts.md describes the fields.
std::string to_json(const StatsReport& report);

/// Returns one row per move: pattern,move,total,difference, and with a pack latency_ms,bytes.
std::string to_csv(const StatsReport& report);

/// Returns a table to read, with the published numbers beside the counted ones.
std::string to_table(const StatsReport& report);

}  // namespace cairn
