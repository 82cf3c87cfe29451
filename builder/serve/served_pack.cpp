#include "builder/serve/served_pack.h"

#include <utility>

#include "builder/export/pack_accuracy.h"
#include "cairn/byte_source.h"

namespace cairn {
namespace {

constexpr std::size_t kKeptTiles = 32;  // 32 MiB of metres

/// The bytes of a file that others hold open as well, so that a pack and its file are never two files.
class SharedFileSource : public ByteSource {
 public:
  explicit SharedFileSource(std::shared_ptr<const File> file) : file_(std::move(file)) {}

  const std::filesystem::path& name() const override { return file_->path(); }
  Result<std::uint64_t> size() const override { return file_->size(); }
  Status read(std::uint64_t offset, std::span<std::byte> out) const override {
    return file_->read(offset, out);
  }

 private:
  std::shared_ptr<const File> file_;
};

Result<std::shared_ptr<const OpenedPack>> open_state(const std::filesystem::path& path) {
  auto file = File::open_to_read(path);
  if (!file) return file.error();
  const auto shared = std::make_shared<const File>(std::move(*file));
  auto reader = PackReader::open(std::make_unique<SharedFileSource>(shared));
  if (!reader) return reader.error();
  ServedFile served{shared, reader->header().file_bytes(), '"' + to_string(reader->header().id) + '"',
                    "application/vnd.cairn.pack", "no-cache"};
  return std::shared_ptr<const OpenedPack>(
      std::make_shared<OpenedPack>(std::move(*reader), std::move(served)));
}

bool is_same_file(const struct stat& a, const struct stat& b) {
  return a.st_dev == b.st_dev && a.st_ino == b.st_ino && a.st_size == b.st_size &&
         a.st_mtim.tv_sec == b.st_mtim.tv_sec && a.st_mtim.tv_nsec == b.st_mtim.tv_nsec;
}

}  // namespace

OpenedPack::OpenedPack(PackReader r, ServedFile f)
    : reader(std::move(r)), served(std::move(f)), tiles(reader, kKeptTiles) {
  if (!reader.levels(Layer::heights)) return;
  const PackAccuracy accuracy = accuracy_of(reader);
  patches.emplace(reader, accuracy.finest_error_m);
  const VerticalDatum datum = reader.header().vertical_datum;
  shift.datum = datum;
  if (reader.header().other_datum.empty())
    if (auto found = vertical_shift(datum, ExportHeights::ellipsoidal, {})) shift = std::move(*found);
  auto plan = QuantizedMeshPlan::make(reader, *patches, accuracy.finest_error_m,
                                      {std::nullopt, std::nullopt, std::nullopt, bool(shift.metres)});
  if (plan) meshes.emplace(std::move(*plan));
}

ServedPack::ServedPack(std::filesystem::path path, struct stat state,
                       std::shared_ptr<const OpenedPack> opened)
    : path_(std::move(path)), name_(path_.filename().string()), current_(std::make_unique<Current>()) {
  current_->state = state;
  current_->opened = std::move(opened);
}

Result<ServedPack> ServedPack::open(const std::filesystem::path& path) {
  struct stat state {};
  ::stat(path.c_str(), &state);
  auto opened = open_state(path);
  if (!opened) return opened.error();
  return ServedPack(path, state, std::move(*opened));
}

Result<std::shared_ptr<const OpenedPack>> ServedPack::now() const {
  const std::lock_guard lock(current_->mutex);
  struct stat state {};
  if (::stat(path_.c_str(), &state) == 0 && !is_same_file(state, current_->state)) {
    auto opened = open_state(path_);
    if (!opened) return opened.error();
    current_->opened = std::move(*opened);
    current_->state = state;
  }
  return current_->opened;
}

}  // namespace cairn
