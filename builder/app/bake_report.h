#pragma once

#include <filesystem>
#include <string>

#include "cairn/bake_estimate.h"
#include "cairn/build.h"

namespace cairn {

/// Prints what a bake would do, as a table or as JSON.
void print_dry_run(const DryRun& dry, bool json);

/// Prints what a bake did, from the pack itself; writes the same as JSON to `file` unless that is empty.
Status print_bake_report(const BuildReport& report, const BuildOptions& options, const std::string& file,
                         bool json);

}  // namespace cairn
