#pragma once

#include <cstddef>
#include <string>

#include "cairn/session_options.h"
#include "cairn/status.h"

namespace cairn {

/// Bakes one shard of a plan and prints what was done, as a line or as JSON.
Status bake_part(const std::string& plan, std::size_t shard, const SessionOptions& session, bool json);

}  // namespace cairn
