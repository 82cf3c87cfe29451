#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "cairn/build_options.h"
#include "cairn/status.h"

namespace cairn {

/// The options that decide the bytes of a pack, as its metadata states them: not the target, memory and
/// threads, and of files only whether there are any. Two bakes of equal inputs whose options have equal JSON
/// give the same pack.
nlohmann::ordered_json to_json(const BuildOptions& options);

/// What is said of a source; an empty object where nothing is.
nlohmann::ordered_json to_json(const SourceOverrides& said);

/// The options that JSON of to_json() states, others at their defaults; what the JSON lacks is at its
/// default, too. bad_data names a value of the wrong type or a word that is none of an option's.
Result<BuildOptions> from_json(const nlohmann::json& json);

}  // namespace cairn
