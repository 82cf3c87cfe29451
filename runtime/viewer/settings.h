#pragma once

#include <filesystem>
#include <string>

#include "cairn/status.h"
#include "runtime/viewer/options.h"

namespace cairn::viewer {

/// Returns where a window keeps its settings: $XDG_CONFIG_HOME/cairn/view.json, else in ~/.config; empty
/// where the environment names neither folder.
std::filesystem::path settings_path();

/// Takes into the options what the last window has kept: looks, the sun's hour and the tolerance. A file that
/// is not there changes nothing. bad_data where it is no such file.
Status read_settings(const std::filesystem::path& path, Options& options);

/// Keeps them for the next window, in place of what was there.
Status write_settings(const std::filesystem::path& path, const Options& options);

}  // namespace cairn::viewer
