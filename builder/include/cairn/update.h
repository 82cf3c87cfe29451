#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "cairn/build.h"
#include "cairn/progress.h"
#include "cairn/session_options.h"
#include "cairn/status.h"

namespace cairn {

/// How the inputs of a pack change.
struct UpdateOptions {
  std::filesystem::path pack;
  std::vector<std::filesystem::path> dems;    ///< new ones, and new versions of those of the pack
  std::vector<std::filesystem::path> images;  ///< likewise
  std::vector<std::filesystem::path> places;  ///< likewise, of objects
  std::filesystem::path models;               ///< the folder of the objects' models; empty for the pack's own
  std::vector<std::filesystem::path> removed;  ///< sources of the pack, by path or by the name of the file
  SessionOptions session;                      ///< with the pack as its target, that is replaced
  bool dry_run = false;                        ///< only says what would be done
};

/// What an update does.
struct UpdateReport {
  struct Change {
    std::string what;  ///< "added", "changed" or "removed"
    std::filesystem::path path;
  };
  std::vector<Change> changes;
  std::uint64_t made_units = 0;   ///< subtrees of at most 16 leaves that are made of the sources
  std::uint64_t taken_units = 0;  ///< likewise, that are taken from the pack
  bool knows_units = true;        ///< PACK.units is there and this pack's; else all are made again
  BuildOptions options;           ///< of the full bake whose bytes the new pack has
  BuildReport build;              ///< of the new pack, unless `dry_run`
};

/// Gives a pack the bytes that a full bake of its changed set of inputs has, with the pack's own options. A
/// unit is made again only where a source that reaches it has changed; else its tiles are copied.
///
/// A file of `dems`, `images` or `places` whose name is that of a source of the pack takes its place; another
/// one is added behind all others. Where the files name the whole new set, their order counts instead, as in
/// a bake. Sources that are not named stay and have to be where they were. Triangulations and objects are all
/// made again.
Result<UpdateReport> update_pack(const UpdateOptions& options, const ProgressCallback& progress);

}  // namespace cairn
