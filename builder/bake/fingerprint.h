#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "cairn/status.h"

namespace cairn {

/// XXH3 (64 bits) of a whole file, read in pieces. `failed` where the TBB task that asks is cancelled.
Result<std::uint64_t> hash_file(const std::filesystem::path& path);

/// hash_file() of many files, on all threads of the caller's arena; in the order of `paths`.
Result<std::vector<std::uint64_t>> hash_files(const std::vector<std::filesystem::path>& paths);

/// One number for inputs and options: bakes with one fingerprint give one pack. `options` is a text of all
/// else that decides the bytes.
std::uint64_t fingerprint(const std::string& options, const std::vector<std::uint64_t>& input_hashes);

}  // namespace cairn
