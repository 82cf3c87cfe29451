#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "builder/raster/io/byte_sink.h"
#include "cairn/status.h"

namespace cairn {

/// A file inside a zip archive, as the archive's directory lists it.
struct ZipEntry {
  std::string name;  ///< with its folders, as the archive writes it
  std::uint64_t bytes = 0;
  std::uint64_t index = 0;
};

/// The archive's files, read through libzip. Folders are left out, and so is what macOS adds to each archive:
/// `__MACOSX/` and files whose names begin with `._` hold no file's contents, but its attributes. bad_data
/// where the directory is damaged or is no directory.
Result<std::vector<ZipEntry>> list_zip(const std::filesystem::path& path);

/// Hands on the entry's bytes, unpacked. bad_data where the entry is damaged, encrypted, packed by a method
/// that libzip does not know or longer than its directory says, or where its checksum differs.
Status unpack_zip_entry(const std::filesystem::path& path, const ZipEntry& entry, const ByteSink& sink);

}  // namespace cairn
