#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "builder/bake/bake_session.h"
#include "builder/bake/tile_tree.h"
#include "builder/heights/height_layer.h"
#include "builder/imagery/imagery_layer.h"
#include "builder/pack/bake_plan.h"
#include "cairn/build.h"
#include "cairn/progress.h"

namespace cairn {

/// Makes all tiles of one layer and adds them to the session's pack, in the order of the tree's walk. `now`
/// is the progress from the layer's start.
template <class L>
using MakeLayer = std::function<Status(L& layer, const TileTree& tree, Progress& now)>;

/// Where the tiles of a pack come from: the sources, parts, or an older pack.
struct LayerMakers {
  MakeLayer<HeightLayer> heights;
  MakeLayer<ImageryLayer> imagery;
};

/// Returns the header of the pack that a plan will give.
PackHeader header_for(const BakePlan& layers, const BuildOptions& options);

/// Returns what tells this bake's unfinished work from another's.
BakeIdentity identity_of(const BuildOptions& options);

/// Returns how many samples of the layer's finest level a leaf counts for in a Progress.
std::uint64_t samples_per_leaf(int tile_size);

/// Makes every tile of every layer, holds the measured accuracy against the error bound, and finishes the
/// pack. `hashes` gives those of all inputs, and may wait for them. The report lacks what the caller knows:
/// times, threads, whether it was resumed. After an error the session is as it was left.
Result<BuildReport> make_pack(const BakePlan& layers, const BuildOptions& options, int threads,
                              BakeSession& session, const LayerMakers& makers,
                              const std::function<Result<std::vector<std::uint64_t>>()>& hashes,
                              const ProgressCallback& progress);

/// Returns whether an error is that of an error bound that is not kept.
bool is_error_of_bound(const Error& error);

/// Returns an error where a post is farther off than its error bound says.
Status check_error_bound(const ErrorStats& accuracy);

}  // namespace cairn
