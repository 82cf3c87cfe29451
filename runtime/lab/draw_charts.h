#pragma once

#include <filesystem>

#include "cairn/status.h"

namespace cairn {

/// Runs cairn-lab-charts, which lies beside this program, on a folder with frames.csv and summary.json, where
/// it writes index.html. Returns an error of code failed if it cannot.
Status draw_charts(const std::filesystem::path& folder);

}  // namespace cairn
