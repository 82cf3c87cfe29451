#include "builder/bake/bake_target.h"

#include <algorithm>
#include <array>
#include <string>
#include <system_error>
#include <vector>

#include "builder/bake/journal.h"
#include "builder/bake/output_check.h"
#include "cairn/pack_layout.h"
#include "format/file.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

fs::path part_of(const fs::path& target) {
  return fs::path(target).concat(".part");
}

/// The first bytes of a file, fewer where it is shorter; nothing where it cannot be read.
std::vector<std::byte> first_bytes(const fs::path& path) {
  const auto file = File::open_to_read(path);
  const auto size = file ? file->size() : Result<std::uint64_t>(std::uint64_t{0});
  std::vector<std::byte> bytes(
      static_cast<std::size_t>(size ? std::min<std::uint64_t>(*size, kPackHeaderBytes) : 0));
  if (bytes.empty() || !file->read(0, bytes)) return {};
  return bytes;
}

bool begins_with(std::span<const std::byte> bytes, std::span<const char> magic) {
  return bytes.size() >= magic.size() &&
         std::equal(magic.begin(), magic.end(), bytes.begin(),
                    [](char c, std::byte b) { return std::byte(static_cast<unsigned char>(c)) == b; });
}

bool is_blank(std::span<const std::byte> bytes) {
  return std::all_of(bytes.begin(), bytes.end(), [](std::byte b) { return b == std::byte{0}; });
}

/// A pack by its name or its first bytes, or an empty file that waits for one.
bool may_be_replaced(const fs::path& target) {
  std::error_code ignored;
  if (target.extension() == ".cairn" || fs::file_size(target, ignored) == 0) return true;
  return begins_with(first_bytes(target), kPackMagic);
}

/// An unfinished file of a bake has zeros for a header, and its magic only when it is identified.
Status check_unfinished(const fs::path& path, std::span<const char> magic) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return {};
  if (!fs::is_regular_file(path, ignored))
    return usage_error(path.string() + ": expected no such file, or an interrupted bake's, found no file");
  std::vector<std::byte> bytes = first_bytes(path);
  if (is_blank(std::span(bytes).first(std::min(bytes.size(), magic.size()))) || begins_with(bytes, magic))
    return {};
  return usage_error(path.string() +
                     ": expected no such file, or an interrupted bake's, found another program's");
}

}  // namespace

fs::path units_path(const fs::path& pack) {
  return fs::path(pack).concat(".units");
}

Status check_target_is_no_input(const fs::path& target, std::span<const fs::path> inputs) {
  for (const fs::path& output : {target, part_of(target), Journal::path_for(target), units_path(target)}) {
    if (auto status = check_is_no_input(output, inputs); !status) return status;
  }
  return {};
}

Status check_target(const SessionOptions& options, std::span<const fs::path> inputs) {
  const fs::path& target = options.target;
  if (auto status = check_target_is_no_input(target, inputs); !status) return status;
  if (auto status = check_can_be_file(target); !status) return status;
  std::error_code ignored;
  const bool exists = fs::exists(target, ignored);
  if (exists && !options.force) return usage_error(target.string() + std::string(kTargetExists));
  if (exists && !may_be_replaced(target))
    return usage_error(target.string() + ": expected a pack to replace, found a file that is none");
  if (auto status = check_unfinished(part_of(target), kPackMagic); !status) return status;
  for (const fs::path& records : {Journal::path_for(target), units_path(target)}) {
    if (auto status = check_unfinished(records, Journal::kMagic); !status) return status;
  }
  if (options.resume || options.force || !Journal::fingerprint_of(target)) return {};
  return usage_error(part_of(target).string() + std::string(kWorkExists));
}

Status check_part_target(const SessionOptions& options, std::span<const fs::path> inputs) {
  const fs::path& target = options.target;
  for (const fs::path& output : {target, Journal::path_for(target)}) {
    if (auto status = check_is_no_input(output, inputs); !status) return status;
  }
  if (auto status = check_can_be_file(target); !status) return status;
  std::error_code ignored;
  const bool exists = fs::exists(target, ignored);
  if (exists && !options.force) return usage_error(target.string() + std::string(kTargetExists));
  if (exists && !begins_with(first_bytes(target), Journal::kMagic))
    return usage_error(target.string() + ": expected a part to replace, found a file that is none");
  if (auto status = check_unfinished(Journal::path_for(target), Journal::kMagic); !status) return status;
  if (options.resume || options.force || !Journal::fingerprint_of(target)) return {};
  return usage_error(Journal::path_for(target).string() + std::string(kWorkExists));
}

}  // namespace cairn
