#include "builder/raster/expand_inputs.h"

#include <algorithm>
#include <fstream>
#include <system_error>

#include <fmt/format.h>
#include <fnmatch.h>

#include "builder/raster/gdal_name.h"
#include "builder/raster/packed_raster.h"
#include "builder/raster/raster_names.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

bool is_hidden(const fs::path& path) {
  const std::string name = path.filename().string();
  return name.starts_with('.') || name == "__MACOSX";
}

/// A link that leads to no file; the error names both.
Status check_link(const fs::path& path) {
  std::error_code error;
  if (!fs::is_symlink(fs::symlink_status(path, error)) || fs::exists(path, error)) return {};
  return bad_data(path.string() + ": expected a link to a file, found that " +
                  fs::read_symlink(path, error).string() + " is not there");
}

/// Names in a folder, sorted. With `recursive` those of all folders in it too.
Result<std::vector<fs::path>> names_in(const fs::path& folder, bool recursive) {
  std::error_code error;
  std::vector<fs::path> names;
  fs::recursive_directory_iterator entry(folder, error);
  for (const fs::recursive_directory_iterator end; !error && entry != end; entry.increment(error)) {
    std::error_code ignored;
    const bool is_folder = entry->is_directory(ignored);
    if (is_folder && (!recursive || is_hidden(entry->path()))) entry.disable_recursion_pending();
    if (!is_folder) names.push_back(entry->path());
  }
  if (error) return bad_data(folder.string() + ": expected a readable folder, found: " + error.message());
  std::sort(names.begin(), names.end());
  return names;
}

Status expand_folder(const fs::path& folder, const InputSearch& search, InputFiles& out) {
  const auto names = names_in(folder, search.recursive);
  if (!names) return names.error();
  const std::size_t before = out.files.size();
  for (const fs::path& name : *names) {
    if (is_hidden(name)) continue;
    const bool packed = is_zip_name(name) || is_gzip_name(name);
    if (packed || has_raster_name(name)) {
      if (auto status = check_link(name); !status) return status;
    }
    std::error_code ignored;
    if (!fs::is_regular_file(name, ignored)) continue;
    if (is_raster_file(name)) {
      out.files.push_back(name);
    } else if (packed) {
      out.without_raster.push_back(name);
    }
  }
  if (out.files.size() > before) return {};
  return bad_data(folder.string() + ": expected rasters in the folder, found none");
}

Status expand_pattern(const fs::path& path, InputFiles& out) {
  const std::string pattern = path.filename().string();
  const auto names = names_in(path.has_parent_path() ? path.parent_path() : fs::path("."), false);
  if (!names) return names.error();
  const std::size_t before = out.files.size();
  for (const fs::path& name : *names) {
    if (::fnmatch(pattern.c_str(), name.filename().c_str(), FNM_PERIOD) != 0) continue;
    if (auto status = check_link(name); !status) return status;
    std::error_code ignored;
    if (fs::is_regular_file(name, ignored))
      out.files.push_back(path.has_parent_path() ? name : name.filename());
  }
  if (out.files.size() > before) return {};
  return bad_data(path.string() + ": expected files that match, found none");
}

Status expand_named(const std::string& argument, const InputSearch& search, InputFiles& out) {
  const fs::path path(argument);
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return expand_folder(path, search, out);
  if (fs::exists(path, ignored)) {
    out.files.push_back(path);
    return {};
  }
  if (file_of_gdal_name(path)) {
    out.files.push_back(path);
    return {};
  }
  if (auto status = check_link(path); !status) return status;
  if (path.filename().string().find_first_of("*?[") != std::string::npos) return expand_pattern(path, out);
  return bad_data(argument + ": expected a file, a folder or a pattern, found nothing of that name");
}

Status expand_list(const std::string& list, const InputSearch& search, InputFiles& out) {
  std::ifstream in(list);
  if (!in) return bad_data(list + ": expected a readable list of inputs, found none");
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') continue;
    const std::size_t last = line.find_last_not_of(" \t\r");
    const Status status = expand_named(line.substr(first, last - first + 1), search, out);
    if (!status)
      return Error{status.error().code, fmt::format("{}: line {}: {}", list, number, status.error().message)};
  }
  return {};
}

}  // namespace

Result<InputFiles> expand_inputs(std::span<const std::string> arguments, const InputSearch& search) {
  InputFiles out;
  for (const std::string& argument : arguments) {
    std::error_code ignored;
    const bool is_list = argument.starts_with('@') && !fs::exists(argument, ignored);
    const Status status =
        is_list ? expand_list(argument.substr(1), search, out) : expand_named(argument, search, out);
    if (!status) return status.error();
  }
  return out;
}

}  // namespace cairn
