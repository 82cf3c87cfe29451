#pragma once

#include <optional>

#include "builder/pack/bake_plan.h"
#include "builder/shard/shard_plan.h"
#include "cairn/build_options.h"

namespace cairn {

/// Returns the options of the bake that was planned, without a target. bad_data names what is wrong in them.
Result<BuildOptions> options_of(const ShardPlan& plan);

/// Returns the plan's sources as they were when it was made. Of a shard's bake its own alone are available,
/// of a merge none.
KnownSources sources_of(const ShardPlan& plan, std::optional<std::size_t> shard);

/// Returns the file as it is now, with the side-cars beside it.
Result<PlannedFile> look_at(const std::filesystem::path& path);

/// Compares the shard's files with what they were. The error is failed where one is not there, bad_data where
/// one has changed.
Status check_files(const ShardPlan& plan, const Shard& shard);

/// check_files() for the places and models of the objects, which a merge reads: there are no other models in
/// their folder, either.
Status check_object_files(const ShardPlan& plan, const BuildOptions& options);

}  // namespace cairn
