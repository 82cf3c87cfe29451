#include "builder/bake/fingerprint.h"

#include <algorithm>
#include <optional>
#include <span>

#include <tbb/parallel_for.h>
#include <tbb/task_group.h>
#include <xxhash.h>

#include "format/checksum.h"
#include "format/file.h"

namespace cairn {
namespace {

constexpr std::uint64_t kPieceBytes = 1 << 20;

}  // namespace

Result<std::uint64_t> hash_file(const std::filesystem::path& path) {
  const auto file = File::open_to_read(path);
  if (!file) return file.error();
  const auto size = file->size();
  if (!size) return size.error();
  ChecksumStream sum;
  std::vector<std::byte> piece(static_cast<std::size_t>(std::min(*size, kPieceBytes)));
  for (std::uint64_t at = 0; at < *size; at += piece.size()) {
    const auto bytes =
        std::span(piece).first(static_cast<std::size_t>(std::min<std::uint64_t>(piece.size(), *size - at)));
    if (tbb::is_current_task_group_canceling()) return failed(path.string() + ": hashing is cancelled");
    if (auto status = file->read(at, bytes); !status) return status.error();
    sum.add(bytes);
  }
  return sum.value();
}

Result<std::vector<std::uint64_t>> hash_files(const std::vector<std::filesystem::path>& paths) {
  std::vector<std::optional<Result<std::uint64_t>>> results(paths.size());
  tbb::parallel_for(std::size_t{0}, paths.size(), [&](std::size_t i) { results[i] = hash_file(paths[i]); });
  std::vector<std::uint64_t> hashes;
  for (const auto& result : results) {
    if (!*result) return result->error();
    hashes.push_back(**result);
  }
  return hashes;
}

std::uint64_t fingerprint(const std::string& options, const std::vector<std::uint64_t>& input_hashes) {
  const std::uint64_t words = XXH3_64bits(options.data(), options.size());
  return XXH3_64bits_withSeed(input_hashes.data(), input_hashes.size() * sizeof(std::uint64_t), words);
}

}  // namespace cairn
