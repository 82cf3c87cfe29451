#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "cairn/source_rule.h"
#include "cairn/status.h"

namespace cairn {

/// What the command line says of DEMs: of all of them, or in a file with a line for each pattern.
struct SourceArguments {
  SourceOverrides all;
  std::string file;
  std::vector<std::string> include;
  std::vector<std::string> exclude;
};

void add_source_options(CLI::App& verb, SourceArguments& arguments);

/// The rule for all sources, then those of the file in its order.
Result<std::vector<SourceRule>> source_rules(const SourceArguments& arguments);

/// What the command line says of images: where all sources lie, DEMs and images, and which samples are black
/// and white. `range`: these two, or empty.
std::vector<SourceRule> image_rules(const SourceArguments& arguments, const std::vector<double>& range);

/// Parses the lines of such a file: a glob pattern and any of band=, nodata=, scale=, offset=, unit=, crs=,
/// body=, latitude=, longitude=, priority=, apart by blanks; a value with blanks stands in "quotes"; # begins
/// a comment. Errors begin with `name`.
Result<std::vector<SourceRule>> parse_source_rules(std::string_view text, const std::string& name);

/// The files that match a pattern of `include`, where there is any, and none of `exclude`. usage_error where
/// no file is left of some.
Result<std::vector<std::filesystem::path>> chosen_files(std::vector<std::filesystem::path> files,
                                                        const SourceArguments& arguments);

}  // namespace cairn
