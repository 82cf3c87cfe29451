#pragma once

#include <cstdint>
#include <vector>

#include "builder/build_options.h"
#include "builder/fingerprint.h"
#include "builder/journal.h"
#include "format/pack_writer.h"
#include "format/status.h"

namespace cairn {

/// A bake under way: what it writes to, and what an interrupted one has already done.
struct Work {
  PackWriter writer;
  Journal journal;
  std::vector<UnitRecord> done;
  bool resumed = false;
};

/// Hashes of all inputs: DEMs, images, the geoid.
Result<std::vector<std::uint64_t>> hash_inputs(const BuildOptions& options);

/// With `options.resume`, and a journal of the same inputs and options beside the target: goes on after the
/// last unit whose blocks are whole, each checked by its checksum. Else starts anew.
Result<Work> begin_or_resume(const BuildOptions& options, const PackHeader& header,
                             const std::vector<std::uint64_t>& input_hashes);

/// After an error: with `options.resume` the work stays for another try, else it is removed. Returns the
/// error.
Error discard(const BuildOptions& options, Work& work, Error error);

void remove_journal(const std::filesystem::path& target);

}  // namespace cairn
