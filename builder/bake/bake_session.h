#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <tbb/task_group.h>

#include "builder/bake/fingerprint.h"
#include "builder/bake/journal.h"
#include "builder/bake/pipeline.h"
#include "cairn/session_options.h"
#include "cairn/status.h"
#include "format/pack_writer.h"

namespace cairn {

/// What tells one bake's journal from another's.
struct BakeIdentity {
  std::vector<std::filesystem::path> inputs;  ///< every file whose bytes decide the pack's
  std::string options;                        ///< all else that decides them, as text
};

/// A bake under way: what it writes to, and what an interrupted one has already done.
struct BakeSession {
  SessionOptions options;
  BakeIdentity identity;
  PackWriter writer;
  Journal journal;
  std::vector<RecordPlace> done;  ///< in the journal: the units that need not be baked again
  std::optional<std::vector<std::uint64_t>> input_hashes;  ///< where the journal of another try needed them
  bool resumed = false;
};

/// How the error ends where the work beside the target is of other inputs or options.
inline constexpr std::string_view kOtherWork =
    ": expected a bake of these inputs and options, found another's";

/// With `options.resume`, and a journal of the same inputs and options beside the target: goes on after the
/// last unit whose blocks are whole, each checked by its checksum. Else starts anew. Work of other inputs or
/// options is wrong usage (kOtherWork), unless `options.force` is set.
Result<BakeSession> begin_session(const SessionOptions& options, BakeIdentity identity,
                                  const PackHeader& header);

/// Hashes the inputs on the caller's arena while the bake goes on, and lets the
/// journal know: a file is hashed by one thread, and the others would wait.
class InputHashing {
 public:
  /// Starts. REQUIRES: the session outlives it and stays where it is.
  explicit InputHashing(BakeSession& session);
  /// Cancels what is not hashed yet.
  ~InputHashing();
  InputHashing(const InputHashing&) = delete;
  InputHashing& operator=(const InputHashing&) = delete;

  /// In the order of the inputs. Waits for them.
  Result<std::vector<std::uint64_t>> hashes();

 private:
  void hash();

  BakeSession& session_;
  std::optional<Result<std::vector<std::uint64_t>>> hashes_;
  std::atomic<std::size_t> order_ = 0;  // see OrderedTurn
  tbb::task_group tasks_;
};

/// Ends a bake after an error. Returns the error. `TARGET.part` and `TARGET.journal` are kept where another
/// bake with `options.resume` can go on from them; for that it waits for the hashes, without which the
/// journal could not be told from another bake's. Otherwise both are removed: no unit is done yet, or the
/// inputs are bad.
Error end_failed_bake(BakeSession& session, InputHashing& hashing, Error error);

void remove_journal(const std::filesystem::path& target);

}  // namespace cairn
