#pragma once

#include <filesystem>

#include "cairn/pack_reader.h"
#include "cairn/status.h"

namespace cairn {

/// Refuses, as wrong usage, an output of a verb that reads a pack where it would write over the pack or over
/// one of the files that the pack was baked from. These are known by the hashes in the pack's metadata,
/// wherever they lie and whatever they are called. Also refused is an output that is a folder, and one whose
/// `OUTPUT.part`, which is written first, exists already.
Status check_export_target(const std::filesystem::path& output, const PackReader& pack);

}  // namespace cairn
