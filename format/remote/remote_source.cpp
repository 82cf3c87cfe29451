#include "format/remote/remote_source.h"

#include <algorithm>
#include <cstdlib>

namespace cairn {
namespace {

constexpr std::uint64_t kWidestGap = 16 << 10;  // bytes that cost less than another request
constexpr std::uint64_t kMostInOne = 4 << 20;

std::uint64_t end_of(ByteRange range) {
  return range.offset + range.bytes;
}

std::filesystem::path default_cache_folder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  if (cache != nullptr && *cache != '\0') return std::filesystem::path(cache) / "cairn";
  const char* home = std::getenv("HOME");
  return home != nullptr && *home != '\0' ? std::filesystem::path(home) / ".cache" / "cairn"
                                          : std::filesystem::path();
}

}  // namespace

Result<std::unique_ptr<RemoteSource>> RemoteSource::open(const std::string& address,
                                                         const RemoteOptions& options) {
  const auto curl = curl_library();
  if (!curl) return Error{curl.error().code, address + ": " + curl.error().message};
  std::unique_ptr<RemoteSource> source(new RemoteSource(**curl, address, options));
  auto first = source->client_.get({0, kPackStartBytes}, true);
  if (!first) return source->told(first.error());
  source->first_ = std::move(*first);
  const auto& start = source->first_.bytes;
  const auto header = decode_header(std::span(start).first(std::min(start.size(), kPackHeaderBytes)));
  if (!header) return source->told(header.error());
  const auto folder = options.cache_folder.empty() ? default_cache_folder() : options.cache_folder;
  if (options.cache_bytes > 0 && !folder.empty())
    source->cache_.emplace(folder, options.cache_bytes, header->id);
  return source;
}

// Whether the range is for this thread to ask for; else another one does. REQUIRES: mutex_ is held.
bool RemoteSource::claim(ByteRange range) const {
  return under_way_.insert({range.offset, range.bytes}).second;
}

void RemoteSource::release(std::span<const ByteRange> ranges) const {
  const std::lock_guard lock(mutex_);
  for (const ByteRange& range : ranges) under_way_.erase({range.offset, range.bytes});
  arrived_.notify_all();
}

// The wanted range, and of the others those that adjoin it, in ascending order. None where another thread
// asks for the wanted one. REQUIRES: mutex_ is held.
std::vector<ByteRange> RemoteSource::claim_with_neighbours(ByteRange wanted,
                                                           std::span<const ByteRange> likely_next) const {
  if (!claim(wanted)) return {};
  std::vector<ByteRange> others(likely_next.begin(), likely_next.end());
  std::sort(others.begin(), others.end(),
            [](const ByteRange& a, const ByteRange& b) { return a.offset < b.offset; });
  std::vector<ByteRange> taken{wanted};
  const auto take_those = [&](auto begin, auto end, bool above) {
    for (auto it = begin; it != end; ++it) {
      const std::uint64_t first = std::min(it->offset, taken.front().offset);
      const std::uint64_t last = std::max(end_of(*it), end_of(taken.back()));
      const bool adjoins =
          above ? it->offset >= end_of(taken.back()) && it->offset - end_of(taken.back()) <= kWidestGap
                : end_of(*it) <= taken.front().offset && taken.front().offset - end_of(*it) <= kWidestGap;
      if (!adjoins || last - first > kMostInOne || end_of(*it) > first_.file_bytes) continue;
      if (cache_->has(*it) || !claim(*it)) continue;
      taken.insert(above ? taken.end() : taken.begin(), *it);
    }
  };
  if (!cache_) return taken;
  take_those(others.begin(), others.end(), true);
  take_those(others.rbegin(), others.rend(), false);
  return taken;
}

Status RemoteSource::fetch(std::span<const ByteRange> ranges, ByteRange wanted,
                           std::span<std::byte> out) const {
  const ByteRange all{ranges.front().offset, end_of(ranges.back()) - ranges.front().offset};
  const auto answer = client_.get(all, false);
  if (!answer) return told(answer.error());
  if (answer->file_bytes != first_.file_bytes || answer->etag != first_.etag)
    return told(bad_data("expected the file as it was when it was opened, found another"));
  const auto bytes = std::span(answer->bytes);
  for (const ByteRange& range : ranges) {
    const auto part = bytes.subspan(range.offset - all.offset, range.bytes);
    if (cache_) cache_->write(range.offset, part);
    if (range.offset == wanted.offset && range.bytes == wanted.bytes)
      std::copy(part.begin(), part.end(), out.begin());
  }
  return {};
}

Status RemoteSource::read(std::uint64_t offset, std::span<std::byte> out,
                          std::span<const ByteRange> likely_next) const {
  const ByteRange wanted{offset, out.size()};
  if (out.empty()) return {};
  if (end_of(wanted) <= first_.bytes.size()) {
    const auto part = std::span(first_.bytes).subspan(offset, out.size());
    std::copy(part.begin(), part.end(), out.begin());
    return {};
  }
  for (;;) {
    if (cache_ && cache_->read(offset, out)) return {};
    std::unique_lock lock(mutex_);
    const std::vector<ByteRange> ranges = claim_with_neighbours(wanted, likely_next);
    if (ranges.empty()) {
      arrived_.wait(lock, [&] { return !under_way_.contains({wanted.offset, wanted.bytes}); });
      continue;
    }
    lock.unlock();
    const Status status = fetch(ranges, wanted, out);
    release(ranges);
    return status;
  }
}

Result<bool> RemoteSource::recheck(ByteRange range) const {
  if (cache_) cache_->remove(range);
  const auto now = client_.get({0, kPackStartBytes}, true);
  if (!now) return told(now.error());
  if (now->bytes != first_.bytes || now->file_bytes != first_.file_bytes)
    return told(bad_data("expected the file as it was when it was opened, found another"));
  return true;
}

bool is_remote(const std::string& pack) {
  return pack.starts_with("http://") || pack.starts_with("https://");
}

Result<PackReader> open_pack(const std::string& pack, const RemoteOptions& options) {
  if (!is_remote(pack)) return PackReader::open(pack);
  auto source = RemoteSource::open(pack, options);
  if (!source) return source.error();
  return PackReader::open(std::move(*source));
}

}  // namespace cairn
