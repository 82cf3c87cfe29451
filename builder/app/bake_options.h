#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "builder/app/source_options.h"
#include "builder/raster/expand_inputs.h"
#include "cairn/build_options.h"
#include "cairn/status.h"

namespace cairn {

/// What the command line says of a bake: which inputs, and all that decides the bytes of the pack.
struct BakeArguments {
  std::vector<std::string> inputs;
  BuildOptions options;
  std::vector<std::string> images;
  std::vector<std::string> places;
  std::string models;
  std::vector<double> region;
  SourceArguments sources;
  std::vector<double> image_bounds;
  std::vector<double> image_range;  ///< empty, or the samples that become black and white
  std::string level = "auto";
  std::string geoid;
  std::size_t memory_mib = 1024;
  InputSearch search;
};

/// Adds inputs and all options that decide the bytes of a pack.
void add_bake_options(CLI::App& verb, BakeArguments& arguments);

/// Puts the rasters that the arguments name into `out`, and warns of archives that hold none.
Status find_inputs(const std::vector<std::string>& arguments, const InputSearch& search,
                   std::vector<std::filesystem::path>& out);

/// Adds --memory and --threads.
void add_machine_options(CLI::App& verb, BakeArguments& arguments);

/// Returns the options of the library. The error is usage where there are no inputs, or options contradict
/// one another.
Result<BuildOptions> options_from(const BakeArguments& arguments);

}  // namespace cairn
