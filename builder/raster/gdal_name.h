#pragma once

#include <filesystem>
#include <optional>

namespace cairn {

/// The file that a name of GDAL's leads to, which is no path itself: a subdataset (NETCDF:"f.nc":z,
/// HDF5:f.h5://z, GTIFF_DIR:2:f.tif) or a place in an archive (/vsizip/a.zip/b.tif). nullopt where the name
/// is a path, or no file is there.
std::optional<std::filesystem::path> file_of_gdal_name(const std::filesystem::path& name);

}  // namespace cairn
