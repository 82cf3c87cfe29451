#pragma once

#include <filesystem>

#include "cairn/status.h"

namespace cairn {

/// Runs cairn-lab-charts, which lies beside this program, on a folder with frames.csv and summary.json: it
/// writes index.html there. Failed, saying why, where it cannot.
Status draw_charts(const std::filesystem::path& folder);

}  // namespace cairn
