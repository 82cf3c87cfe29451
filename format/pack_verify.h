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

/// Checks every rule of docs/pack-format.md that the file alone can show.
///
/// These are: checksums; header, blocks, index and metadata cover each byte once, so that no byte can change
/// unnoticed; each tile decodes, and its entry agrees with it; parents exist, have their children's every
/// second sample and no smaller error; neighbours, also across the antimeridian, share their edge samples bit
/// for bit; what overhangs the world is void; the triangulations of Layer::rqt are those that the heights
/// give.
///
/// Each tile is decoded once, with an rqt layer three times. 112 bytes per tile are kept, and with rqt 4
/// bytes per edge sample for each tile of a level. Damage is a finding; the error says why the file could not
/// be read. Findings are in the index's order, whatever the number of threads, unless most_findings ends the
/// search.
Result<VerifyReport> verify_pack(const std::filesystem::path& path, const VerifyOptions& options = {});

}  // namespace cairn
