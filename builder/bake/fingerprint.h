#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "cairn/build_options.h"
#include "cairn/status.h"

namespace cairn {

/// XXH3 (64 bits) of a whole file, read in pieces. `failed` where the TBB task that asks is cancelled.
Result<std::uint64_t> hash_file(const std::filesystem::path& path);

/// The same for many files, on all threads of the caller's arena; in the order of `paths`.
Result<std::vector<std::uint64_t>> hash_files(const std::vector<std::filesystem::path>& paths);

/// The options that decide the bytes of a pack, as text: not the memory, the threads or the names of files.
std::string describe_options(const BuildOptions& options);

/// One number for inputs and options: bakes with the same give the same pack.
std::uint64_t fingerprint(const std::string& options, const std::vector<std::uint64_t>& input_hashes);

}  // namespace cairn
