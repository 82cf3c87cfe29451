#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "builder/raster/io/input_file.h"
#include "builder/raster/io/scratch_bytes.h"
#include "cairn/status.h"

namespace cairn {

/// A file inside a zip archive, as the archive's directory lists it.
struct ZipEntry {
  std::string name;
  std::uint16_t flags = 0;
  std::uint16_t method = 0;  ///< 0 stored, 8 deflated
  std::uint32_t crc32 = 0;
  std::uint32_t packed_bytes = 0;
  std::uint32_t bytes = 0;
  std::uint32_t header_offset = 0;
};

/// The archive's directory (PKWARE APPNOTE 4.3.12). Archives past 4 GiB (zip64) or in parts are bad_data.
Result<std::vector<ZipEntry>> list_zip(const InputFile& file);

/// Appends the entry's bytes, unpacked, to `out`. bad_data where the entry is damaged, encrypted or packed by
/// another method, or its checksum differs.
Status unpack_zip_entry(const InputFile& file, const ZipEntry& entry, ScratchBytes& out);

}  // namespace cairn
