#pragma once

#include <string>
#include <vector>

#include "runtime/paging/frame_stats.h"
#include "runtime/stats/block_count.h"

namespace cairn {

/// What loading a move's difference blocks from a pack took.
struct MoveLoad {
  double latency_ms = 0;    ///< from the request to the last block decoded
  std::uint64_t bytes = 0;  ///< of blocks, as stored
};

/// The counts of one pattern, and the loads where there was a pack: then one a move.
struct PatternReport {
  RefinementPattern pattern = RefinementPattern::restricted;
  std::vector<MoveCount> counts;
  std::vector<MoveLoad> loads;
};

/// One run of cairn-stats.
struct StatsReport {
  int levels = 4;
  std::string walk;
  std::uint64_t seed = 0;
  bool exhaustive = false;
  std::string pack;  ///< empty: the endless world
  std::vector<PatternReport> patterns;
};

/// docs/block-counts.md names the fields.
std::string to_json(const StatsReport& report);

/// A row a move: pattern,move,total,difference, and latency_ms,bytes where there was a pack.
std::string to_csv(const StatsReport& report);

/// The table for people, the thesis's numbers beside ours.
std::string to_table(const StatsReport& report);

}  // namespace cairn
