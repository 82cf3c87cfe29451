#include "builder/raster/io/zip_archive.h"

#include <algorithm>
#include <optional>

#include <fmt/format.h>
#include <zlib.h>

#include "builder/raster/io/inflate.h"
#include "builder/raster/io/printable.h"
#include "format/bytes.h"

namespace cairn {
namespace {

constexpr std::uint32_t kEndMark = 0x06054b50;
constexpr std::uint32_t kEntryMark = 0x02014b50;
constexpr std::uint32_t kLocalMark = 0x04034b50;
constexpr std::size_t kEndBytes = 22;
constexpr std::size_t kLocalBytes = 30;
constexpr std::size_t kMostComment = 65535;
constexpr std::uint16_t kEncrypted = 1;

struct Directory {
  std::uint16_t entries = 0;
  std::uint32_t bytes = 0;
  std::uint32_t offset = 0;
};

std::optional<Directory> parse_end(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  if (in.read<std::uint32_t>() != kEndMark) return std::nullopt;
  in.take(6);  // disk numbers, entries on this disk
  Directory directory;
  directory.entries = in.read<std::uint16_t>();
  directory.bytes = in.read<std::uint32_t>();
  directory.offset = in.read<std::uint32_t>();
  return in.ok() ? std::optional(directory) : std::nullopt;
}

/// The directory's end record is the last thing in the file but for a comment of any length.
Result<Directory> find_directory(const InputFile& file) {
  const auto tail_bytes =
      static_cast<std::size_t>(std::min<std::uint64_t>(file.size(), kEndBytes + kMostComment));
  std::vector<std::byte> tail(tail_bytes);
  if (auto read = file.read_at(file.size() - tail_bytes, tail); !read) return read.error();
  for (std::size_t back = kEndBytes; back <= tail_bytes; ++back) {
    const auto directory = parse_end(std::span(tail).subspan(tail_bytes - back, kEndBytes));
    if (directory && std::uint64_t{directory->offset} + directory->bytes <= file.size()) return *directory;
  }
  return bad_data(file.path().string() + ": expected a zip directory at the end, found none (cut off?)");
}

ZipEntry parse_entry(ByteReader& in) {
  ZipEntry entry;
  in.take(4);  // versions
  entry.flags = in.read<std::uint16_t>();
  entry.method = in.read<std::uint16_t>();
  in.take(4);  // date and time
  entry.crc32 = in.read<std::uint32_t>();
  entry.packed_bytes = in.read<std::uint32_t>();
  entry.bytes = in.read<std::uint32_t>();
  const auto name_bytes = in.read<std::uint16_t>();
  const auto extra_bytes = in.read<std::uint16_t>();
  const auto comment_bytes = in.read<std::uint16_t>();
  in.take(8);  // disk, attributes
  entry.header_offset = in.read<std::uint32_t>();
  const auto name = in.take(name_bytes);
  entry.name.assign(reinterpret_cast<const char*>(name.data()), name.size());
  in.take(std::uint64_t{extra_bytes} + comment_bytes);
  return entry;
}

/// Where the entry's data begin: behind its local header, whose name and extra field may differ in length
/// from the directory's.
Result<std::uint64_t> data_offset(const InputFile& file, const ZipEntry& entry) {
  std::vector<std::byte> local(kLocalBytes);
  if (auto read = file.read_at(entry.header_offset, local); !read) return read.error();
  ByteReader in(local);
  const auto mark = in.read<std::uint32_t>();
  in.take(22);
  const auto name_bytes = in.read<std::uint16_t>();
  const auto extra_bytes = in.read<std::uint16_t>();
  const std::uint64_t at = std::uint64_t{entry.header_offset} + kLocalBytes + name_bytes + extra_bytes;
  if (mark != kLocalMark || at + entry.packed_bytes > file.size())
    return bad_data(fmt::format("{}: {}: expected the entry at byte {}, found something else",
                                file.path().string(), printable(entry.name), entry.header_offset));
  return at;
}

Status copy_stored(const InputFile& file, std::uint64_t offset, std::uint64_t count, ScratchBytes& out) {
  constexpr std::uint64_t kStep = 256 * 1024;
  std::vector<std::byte> step;
  for (std::uint64_t done = 0; done < count; done += step.size()) {
    step.resize(static_cast<std::size_t>(std::min(kStep, count - done)));
    if (auto read = file.read_at(offset + done, step); !read) return read;
    if (auto kept = out.append(step); !kept) return kept;
  }
  return {};
}

Result<std::uint32_t> checksum_of(const ScratchBytes& bytes) {
  std::vector<std::byte> step;
  uLong sum = ::crc32(0, nullptr, 0);
  for (std::uint64_t done = 0; done < bytes.size(); done += step.size()) {
    step.resize(static_cast<std::size_t>(std::min<std::uint64_t>(256 * 1024, bytes.size() - done)));
    if (auto read = bytes.read_at(done, step); !read) return read.error();
    sum = ::crc32(sum, reinterpret_cast<const Bytef*>(step.data()), static_cast<uInt>(step.size()));
  }
  return static_cast<std::uint32_t>(sum);
}

}  // namespace

Result<std::vector<ZipEntry>> list_zip(const InputFile& file) {
  const auto directory = find_directory(file);
  if (!directory) return directory.error();
  std::vector<std::byte> bytes(directory->bytes);
  if (auto read = file.read_at(directory->offset, bytes); !read) return read.error();
  ByteReader in(bytes);
  std::vector<ZipEntry> entries;
  for (unsigned i = 0; i < directory->entries; ++i) {
    if (in.read<std::uint32_t>() != kEntryMark || !in.ok()) break;
    entries.push_back(parse_entry(in));
  }
  if (entries.size() != directory->entries || !in.ok())
    return bad_data(fmt::format("{}: expected {} zip entries, found {} and then damage", file.path().string(),
                                directory->entries, entries.size()));
  return entries;
}

Status unpack_zip_entry(const InputFile& file, const ZipEntry& entry, ScratchBytes& out) {
  const std::string place = file.path().string() + ": " + printable(entry.name);
  if ((entry.flags & kEncrypted) != 0)
    return bad_data(place + ": expected a plain entry, found an encrypted one");
  if (entry.method != 0 && entry.method != 8)
    return bad_data(
        fmt::format("{}: expected a stored or deflated entry, found zip method {}", place, entry.method));
  const auto offset = data_offset(file, entry);
  if (!offset) return offset.error();
  const Status unpacked =
      entry.method == 0 ? copy_stored(file, *offset, entry.packed_bytes, out)
                        : inflate(file, *offset, entry.packed_bytes, DeflateWrapping::none, entry.bytes, out);
  if (!unpacked) return unpacked;
  const auto sum = checksum_of(out);
  if (!sum) return sum.error();
  if (*sum != entry.crc32)
    return bad_data(fmt::format("{}: expected the checksum {:08x}, found {:08x}", place, entry.crc32, *sum));
  return {};
}

}  // namespace cairn
