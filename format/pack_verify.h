#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "cairn/status.h"
#include "format/finding.h"

namespace cairn {

struct VerifyReport {
  std::vector<Finding> findings;
  bool ok() const { return findings.empty(); }
};

struct VerifyOptions {
  int threads = 1;                   ///< 1 or more
  std::size_t most_findings = 1000;  ///< the search ends when so many are found
};

/// Checks every rule of docs/pack-format.md that the file alone can show: checksums; that header, blocks,
/// index and metadata cover each byte once, so that no byte can change unnoticed; that each tile decodes and
/// its entry tells the truth; that parents are there, equal their children's every second sample and have no
/// smaller error; that neighbours, also across the antimeridian, share their edge samples bit for bit; that
/// what overhangs the world is void; that the triangulations of Layer::rqt are those that the heights give.
///
/// Each tile is decoded once, where there is an rqt layer three times; 112 bytes a tile are kept, and with
/// rqt 4 bytes a sample of an edge for each tile of a level. Damage is a finding; an error is what kept the
/// file from being read. The findings come in the index's order, whatever the number of threads, unless
/// most_findings cuts them off.
Result<VerifyReport> verify_pack(const std::filesystem::path& path, const VerifyOptions& options = {});

}  // namespace cairn
