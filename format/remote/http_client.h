#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "cairn/byte_source.h"
#include "cairn/remote_pack.h"
#include "cairn/status.h"
#include "format/remote/curl_library.h"

namespace cairn {

/// What a server sent for a range.
struct RangeAnswer {
  std::vector<std::byte> bytes;
  std::uint64_t file_bytes = 0;  ///< of the whole file
  std::string etag;              ///< that changes with the file; empty where the server names none
};

/// Asks one address for ranges. Connections are kept and used again. Any number of threads.
class HttpClient {
 public:
  HttpClient(const CurlLibrary& curl, std::string address, const RemoteOptions& options);
  ~HttpClient();
  HttpClient(const HttpClient&) = delete;
  HttpClient& operator=(const HttpClient&) = delete;

  /// Asks for a range, which may reach past the file's end if `may_be_short`. What may succeed at another try
  /// is tried again: no connection, too little data, the server's errors 429 and 5xx. Errors are without the
  /// address.
  Result<RangeAnswer> get(ByteRange range, bool may_be_short) const;

 private:
  struct Transfer;
  struct Attempt;

  Attempt attempt(ByteRange range, bool may_be_short) const;
  std::unique_ptr<Transfer> borrow() const;
  void give_back(std::unique_ptr<Transfer> transfer) const;

  const CurlLibrary& curl_;
  std::string address_;
  RemoteOptions options_;
  mutable std::mutex mutex_;
  mutable std::vector<std::unique_ptr<Transfer>> idle_;  // guarded by mutex_
};

}  // namespace cairn
