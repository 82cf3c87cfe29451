#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "cairn/status.h"

namespace cairn {

/// How the arguments of a command line are searched for rasters.
struct InputSearch {
  bool recursive = false;  ///< folders with all folders in them; links to folders are not followed
};

/// What the arguments lead to.
struct InputFiles {
  std::vector<std::filesystem::path> files;
  std::vector<std::filesystem::path> without_raster;  ///< packed files of folders in which no raster is
};

/// Returns the files that are named directly, by folder, by a glob pattern in the last component, or by
/// `@LIST`, a text file with one such argument a line (empty lines and those that begin with # count for
/// nothing). The order is that of the arguments; a folder's and a pattern's files are sorted by name. Of a
/// folder, files whose names some raster format has are taken, packed ones by what is in them. bad_data where
/// an argument leads to nothing, and where a link of a folder with a raster's name leads to no file.
Result<InputFiles> expand_inputs(std::span<const std::string> arguments, const InputSearch& search = {});

}  // namespace cairn
