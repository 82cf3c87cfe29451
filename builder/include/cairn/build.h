#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cairn/build_options.h"
#include "cairn/progress.h"
#include "cairn/status.h"

namespace cairn {

/// What a bake did.
struct BuildReport {
  std::string metadata_json;       ///< as it is in the pack
  bool within_error_bound = true;  ///< false only with HeightOptions::allow_error
  std::string warning;             ///< empty where all is well
  std::uint64_t samples = 0;       ///< of the finest tiles of heights
  std::uint64_t texels = 0;        ///< of the finest tiles of imagery
  std::uint64_t file_bytes = 0;
  double seconds = 0;
  int threads = 0;
  bool resumed = false;
};

/// What the caller of a bake that failed can change so that the next one succeeds. The library names no
/// option of a program: the program puts its own words to these.
enum class Remedy {
  replace_target,  ///< SessionOptions::force
  accept_error,    ///< HeightOptions::allow_error
  resume,          ///< SessionOptions::resume: the units that are done are kept beside the target
  tell_body,       ///< SourceOverrides::body
  tell_latitude,   ///< SourceOverrides::latitude
  discard_work,    ///< SessionOptions::force: the work beside the target is given up
};

/// START HERE: from DEMs and images to a verified pack, in numbered steps.
///
/// The same inputs and options give the same bytes, whatever the threads and the memory, also after an
/// interruption that `options.session.resume` goes on from. The target appears when it is whole and its
/// accuracy is measured, or not at all.
///
/// Where `progress` returns false, the bake ends with an error after the units under way. After that and
/// after other errors of the machine (a full disk, an exceeded error bound), the units that are done stay
/// beside the target: remedies_for() then includes Remedy::resume.
Result<BuildReport> build(const BuildOptions& options, const ProgressCallback& progress);

/// The remedies for an error that build() returned for these options, in the order in which they are tried.
std::vector<Remedy> remedies_for(const Error& error, const BuildOptions& options);

}  // namespace cairn
