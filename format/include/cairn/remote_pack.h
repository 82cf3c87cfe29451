#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "cairn/pack_reader.h"
#include "cairn/status.h"

namespace cairn {

/// How a pack is read over HTTP.
struct RemoteOptions {
  /// Where parts that were read are kept; by default `cairn` in $XDG_CACHE_HOME or ~/.cache.
  std::filesystem::path cache_folder;
  std::uint64_t cache_bytes = std::uint64_t{1} << 30;  ///< at most, on the disk; 0 keeps nothing
  int attempts = 5;       ///< of a request that may succeed at another try; 1 or more
  double timeout_s = 30;  ///< of one attempt
};

/// Returns whether the text is the address of a pack, http:// or https://, and no file's name.
bool is_remote(const std::string& pack);

/// Opens a pack by its file's name, or by its address from a server that sends ranges of bytes. Needs
/// libcurl 4, which is loaded for an address only. Errors are one line that begins with the address: the
/// server's refusal, an answer that is no range, a file that is another one than when it was opened.
Result<PackReader> open_pack(const std::string& pack, const RemoteOptions& options = {});

}  // namespace cairn
