#include "builder/raster/expand_inputs.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <system_error>

#include <fnmatch.h>

namespace cairn {
namespace {

namespace fs = std::filesystem;

/// What a folder of rasters may hold besides rasters (.prj, .tfw, .xml, a README) is passed over.
constexpr std::array kExtensions = {".hgt",   ".gz",   ".zip", ".dt0", ".dt1", ".dt2",  ".tif", ".tiff",
                                    ".gtiff", ".tf8",  ".btf", ".png", ".jpg", ".jpeg", ".jp2", ".j2k",
                                    ".bmp",   ".webp", ".exr", ".tga", ".vrt", ".asc",  ".img", ".bil",
                                    ".flt",   ".nc",   ".grd", ".dem", ".bt"};

bool is_raster_by_name(const fs::path& path) {
  if (path.filename().string().starts_with('.')) return false;
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
}

/// Files of a folder that `wanted` accepts, sorted by name.
template <class Wanted>
Result<std::vector<fs::path>> list_folder(const fs::path& folder, Wanted wanted) {
  std::error_code error;
  std::vector<fs::path> found;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (entry->is_regular_file(error) && wanted(entry->path())) found.push_back(entry->path());
  }
  if (error) return bad_data(folder.string() + ": expected a readable folder, found: " + error.message());
  std::sort(found.begin(), found.end());
  return found;
}

Result<std::vector<fs::path>> expand(const std::string& argument) {
  const fs::path path(argument);
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) {
    auto found = list_folder(path, is_raster_by_name);
    if (found && found->empty()) return bad_data(argument + ": expected rasters in the folder, found none");
    return found;
  }
  if (fs::exists(path, ignored)) return std::vector{path};
  const std::string pattern = path.filename().string();
  if (pattern.find_first_of("*?[") == std::string::npos)
    return bad_data(argument + ": expected a file, a folder or a pattern, found nothing of that name");
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  auto found = list_folder(folder, [&](const fs::path& file) {
    return ::fnmatch(pattern.c_str(), file.filename().c_str(), FNM_PERIOD) == 0;
  });
  if (found && found->empty()) return bad_data(argument + ": expected files that match, found none");
  return found;
}

}  // namespace

Result<std::vector<fs::path>> expand_inputs(std::span<const std::string> arguments) {
  std::vector<fs::path> files;
  for (const std::string& argument : arguments) {
    auto found = expand(argument);
    if (!found) return found.error();
    files.insert(files.end(), found->begin(), found->end());
  }
  return files;
}

}  // namespace cairn
