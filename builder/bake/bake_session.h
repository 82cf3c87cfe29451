#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <vector>

#include <tbb/task_group.h>

#include "builder/bake/fingerprint.h"
#include "builder/bake/journal.h"
#include "builder/bake/pipeline.h"
#include "cairn/build_options.h"
#include "format/pack_writer.h"
#include "cairn/status.h"

namespace cairn {

/// A bake under way: what it writes to, and what an interrupted one has already done.
struct BakeSession {
  PackWriter writer;
  Journal journal;
  std::vector<UnitRecord> done;
  std::optional<std::vector<std::uint64_t>> input_hashes;  ///< where the journal of another try needed them
  bool resumed = false;
  bool kept = false;  ///< the work stays although the bake failed
};

/// With `options.resume`, and a journal of the same inputs and options beside the target: goes on after the
/// last unit whose blocks are whole, each checked by its checksum. Else starts anew. Work of other inputs or
/// options is wrong usage, unless `options.force` is set.
Result<BakeSession> begin_session(const BuildOptions& options, const PackHeader& header);

/// Hashes the inputs (DEMs, images, the geoid) on the caller's arena while the bake goes on, and lets the
/// journal know: a file is hashed by one thread, and the others would wait.
class InputHashing {
 public:
  /// Starts. REQUIRES: options and session outlive it and stay where they are.
  InputHashing(const BuildOptions& options, BakeSession& session);
  /// Waits where the work is kept: without the hashes nothing could go on from it.
  ~InputHashing();
  InputHashing(const InputHashing&) = delete;
  InputHashing& operator=(const InputHashing&) = delete;

  /// In the order: DEMs, images, the geoid. Waits for them.
  Result<std::vector<std::uint64_t>> hashes();

 private:
  void hash();

  const BuildOptions& options_;
  BakeSession& session_;
  std::optional<Result<std::vector<std::uint64_t>>> hashes_;
  std::atomic<std::size_t> order_ = 0;  // see OrderedTurn
  tbb::task_group tasks_;
};

/// Ends a session that failed, and returns the error. What is baked stays for another try where it can serve
/// one: with `options.resume`, or where units are done and the inputs were not at fault (a full disk, an
/// error bound that was not kept). Else the bake's own files are removed.
Error discard(const BuildOptions& options, BakeSession& session, Error error);

void remove_journal(const std::filesystem::path& target);

}  // namespace cairn
