#include "builder/raster/io/zip_archive.h"

#include <memory>

#include <fmt/format.h>
#include <zip.h>

#include "builder/raster/io/input_file.h"
#include "builder/raster/io/printable.h"

namespace cairn {
namespace {

constexpr std::size_t kZipStep = 256 * 1024;

struct CloseZip {
  void operator()(zip_t* archive) const { ::zip_discard(archive); }
  void operator()(zip_file_t* file) const { ::zip_fclose(file); }
};
using ArchivePointer = std::unique_ptr<zip_t, CloseZip>;
using EntryPointer = std::unique_ptr<zip_file_t, CloseZip>;

Result<ArchivePointer> open_archive(const std::filesystem::path& path) {
  if (const auto regular = InputFile::open(path); !regular) return regular.error();
  int code = 0;
  ArchivePointer archive(::zip_open(path.c_str(), ZIP_RDONLY, &code));
  if (archive) return archive;
  zip_error_t error;
  ::zip_error_init_with_code(&error, code);
  const std::string reason = ::zip_error_strerror(&error);
  ::zip_error_fini(&error);
  return bad_data(fmt::format("{}: expected a zip archive, found: {}", path.string(), reason));
}

bool is_of_macos(const std::string& name) {
  const std::size_t slash = name.rfind('/');
  const std::string file = slash == std::string::npos ? name : name.substr(slash + 1);
  return name.starts_with("__MACOSX/") || file.starts_with("._") || file == ".DS_Store";
}

}  // namespace

Result<std::vector<ZipEntry>> list_zip(const std::filesystem::path& path) {
  const auto archive = open_archive(path);
  if (!archive) return archive.error();
  std::vector<ZipEntry> entries;
  const zip_int64_t count = ::zip_get_num_entries(archive->get(), 0);
  for (zip_int64_t i = 0; i < count; ++i) {
    zip_stat_t stat;
    const auto index = static_cast<zip_uint64_t>(i);
    if (::zip_stat_index(archive->get(), index, 0, &stat) != 0 || (stat.valid & ZIP_STAT_NAME) == 0 ||
        (stat.valid & ZIP_STAT_SIZE) == 0)
      return bad_data(
          fmt::format("{}: entry {}: expected a name and a size, found damage", path.string(), i));
    const std::string name = stat.name;
    if (name.empty() || name.ends_with('/') || is_of_macos(name)) continue;
    entries.push_back({name, stat.size, index});
  }
  return entries;
}

Status unpack_zip_entry(const std::filesystem::path& path, const ZipEntry& entry, const ByteSink& sink) {
  const auto archive = open_archive(path);
  if (!archive) return archive.error();
  const std::string place = path.string() + ": " + printable(entry.name);
  const EntryPointer file(::zip_fopen_index(archive->get(), entry.index, 0));
  if (!file)
    return bad_data(
        fmt::format("{}: expected an entry that unpacks, found: {}", place, ::zip_strerror(archive->get())));
  std::vector<std::byte> piece(kZipStep);
  for (std::uint64_t done = 0;;) {
    const zip_int64_t got = ::zip_fread(file.get(), piece.data(), piece.size());
    if (got < 0)
      return bad_data(fmt::format("{}: expected {} bytes, found damage after {}: {}", place, entry.bytes,
                                  done, ::zip_file_strerror(file.get())));
    done += static_cast<std::uint64_t>(got);
    if (done > entry.bytes || (got == 0 && done < entry.bytes))
      return bad_data(fmt::format("{}: expected {} bytes, found {}", place, entry.bytes,
                                  got == 0 ? std::to_string(done) : "more"));
    if (got == 0) return {};
    if (auto taken = sink(std::span(piece).first(static_cast<std::size_t>(got))); !taken) return taken;
  }
}

}  // namespace cairn
