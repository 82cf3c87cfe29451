#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cairn/byte_source.h"
#include "cairn/pack_layout.h"
#include "cairn/remote_pack.h"
#include "format/remote/disk_cache.h"
#include "format/remote/http_client.h"

namespace cairn {

/// A pack on a server. Parts that were read are kept on the disk under the pack's id, so a file that was
/// replaced is not mixed with what was read of the old one. Neighbouring parts come in one request.
class RemoteSource : public ByteSource {
 public:
  /// Asks for header and root.
  static Result<std::unique_ptr<RemoteSource>> open(const std::string& address, const RemoteOptions& options);

  const std::filesystem::path& name() const override { return name_; }
  Result<std::uint64_t> size() const override { return first_.file_bytes; }
  bool is_slow() const override { return true; }
  Status read(std::uint64_t offset, std::span<std::byte> out) const override { return read(offset, out, {}); }
  Status read(std::uint64_t offset, std::span<std::byte> out,
              std::span<const ByteRange> likely_next) const override;
  Result<bool> recheck(ByteRange range) const override;

 private:
  using Key = std::pair<std::uint64_t, std::uint64_t>;

  RemoteSource(const CurlLibrary& curl, const std::string& address, const RemoteOptions& options)
      : name_(address), client_(curl, address, options) {}

  Error told(const Error& error) const { return {error.code, name_.string() + ": " + error.message}; }
  bool claim(ByteRange range) const;
  void release(std::span<const ByteRange> ranges) const;
  std::vector<ByteRange> claim_with_neighbours(ByteRange wanted,
                                               std::span<const ByteRange> likely_next) const;
  Status fetch(std::span<const ByteRange> ranges, ByteRange wanted, std::span<std::byte> out) const;

  std::filesystem::path name_;
  HttpClient client_;
  RangeAnswer first_;  // header and root
  mutable std::optional<DiskCache> cache_;
  mutable std::mutex mutex_;
  mutable std::condition_variable arrived_;
  mutable std::set<Key> under_way_;  // guarded by mutex_: ranges that some thread asks for
};

}  // namespace cairn
