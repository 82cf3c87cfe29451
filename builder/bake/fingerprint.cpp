#include "builder/bake/fingerprint.h"

#include <algorithm>
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_group.h>
#include <xxhash.h>

#include "format/file.h"

namespace cairn {
namespace {

constexpr std::uint64_t kPieceBytes = 1 << 20;

template <class T>
std::string text_of(const std::optional<T>& value) {
  return value ? fmt::format("{}", *value) : "auto";
}

}  // namespace

Result<std::uint64_t> hash_file(const std::filesystem::path& path) {
  const auto file = File::open_to_read(path);
  if (!file) return file.error();
  const auto size = file->size();
  if (!size) return size.error();
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), XXH3_freeState);
  XXH3_64bits_reset(state.get());
  std::vector<std::byte> piece(static_cast<std::size_t>(std::min(*size, kPieceBytes)));
  for (std::uint64_t at = 0; at < *size; at += piece.size()) {
    const auto bytes =
        std::span(piece).first(static_cast<std::size_t>(std::min<std::uint64_t>(piece.size(), *size - at)));
    if (tbb::is_current_task_group_canceling()) return failed(path.string() + ": given up");
    if (auto status = file->read(at, bytes); !status) return status.error();
    XXH3_64bits_update(state.get(), bytes.data(), bytes.size());
  }
  return XXH3_64bits_digest(state.get());
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

std::string describe_options(const BuildOptions& o) {
  std::string text =
      fmt::format("tile_size={} level={} top={} max_error={} quantum={} resampling={} voids={} datum={}",
                  o.tile_size, text_of(o.level), text_of(o.top), text_of(o.max_error_m), text_of(o.quantum_m),
                  static_cast<int>(o.resampling), static_cast<int>(o.voids), static_cast<int>(o.datum));
  if (o.region) {
    text +=
        fmt::format(" region={},{},{},{}", o.region->west, o.region->south, o.region->east, o.region->north);
  }
  if (o.rqt_tolerance_m) text += fmt::format(" rqt={}", *o.rqt_tolerance_m);
  if (!o.imagery.inputs.empty()) {
    text += fmt::format(" images={} format={} quality={} feather={}", o.imagery.inputs.size(),
                        static_cast<int>(o.imagery.format), static_cast<int>(o.imagery.quality),
                        o.imagery.feather_pixels);
    if (const auto& b = o.imagery.bounds)
      text += fmt::format(" bounds={},{},{},{}", b->west, b->south, b->east, b->north);
  }
  return text;
}

std::uint64_t fingerprint(const std::string& options, const std::vector<std::uint64_t>& input_hashes) {
  const std::uint64_t words = XXH3_64bits(options.data(), options.size());
  return XXH3_64bits_withSeed(input_hashes.data(), input_hashes.size() * sizeof(std::uint64_t), words);
}

}  // namespace cairn
