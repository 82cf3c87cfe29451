#include "builder/raster/tiff/tiff_handle.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>

#include <tiffio.h>

namespace cairn {
namespace {

constexpr tmsize_t kMostSingleAllocation = tmsize_t{1} << 30;

int keep_complaint(TIFF*, void* handle, const char*, const char* format, std::va_list arguments) {
  char text[256];
  std::vsnprintf(text, sizeof text, format, arguments);
  static_cast<TiffHandle*>(handle)->note(text);
  return 1;
}

int ignore_warning(TIFF*, void*, const char*, const char*, std::va_list) {
  return 1;
}

struct Values {
  std::uint32_t count = 0;
  const void* data = nullptr;
};

/// Unknown tags are anonymous to libtiff and counted in 32 bits; a library in this process (GDAL) may have
/// registered the geographic ones as counted in 16 bits, or strings as not counted at all.
Values values_of(TIFF* tiff, std::uint32_t tag, TIFFDataType type) {
  const TIFFField* field = TIFFFindField(tiff, tag, TIFF_ANY);
  if (field == nullptr || TIFFFieldDataType(field) != type) return {};
  void* data = nullptr;
  if (TIFFFieldPassCount(field) == 0) {
    if (type != TIFF_ASCII || TIFFGetField(tiff, tag, &data) != 1 || data == nullptr) return {};
    return {static_cast<std::uint32_t>(std::strlen(static_cast<const char*>(data))), data};
  }
  std::uint32_t count = 0;
  std::uint16_t short_count = 0;
  const bool wide = TIFFFieldReadCount(field) == TIFF_VARIABLE2;
  const int found =
      wide ? TIFFGetField(tiff, tag, &count, &data) : TIFFGetField(tiff, tag, &short_count, &data);
  if (found != 1 || data == nullptr) return {};
  return {wide ? count : short_count, data};
}

template <class T>
std::vector<T> copied(Values values) {
  std::vector<T> out(values.count);
  if (values.count > 0) std::memcpy(out.data(), values.data, values.count * sizeof(T));
  return out;
}

}  // namespace

Result<std::unique_ptr<TiffHandle>> TiffHandle::open(const std::filesystem::path& path,
                                                     std::uint16_t directory) {
  std::unique_ptr<TiffHandle> handle(new TiffHandle);
  TIFFOpenOptions* options = TIFFOpenOptionsAlloc();
  TIFFOpenOptionsSetErrorHandlerExtR(options, keep_complaint, handle.get());
  TIFFOpenOptionsSetWarningHandlerExtR(options, ignore_warning, nullptr);
  TIFFOpenOptionsSetMaxSingleMemAlloc(options, kMostSingleAllocation);
  // m: no memory map, whose pages would count as ours; c: strips as they are in the file.
  handle->tiff_ = TIFFOpenExt(path.c_str(), "rmc", options);
  TIFFOpenOptionsFree(options);
  if (handle->tiff_ == nullptr)
    return bad_data(path.string() + ": expected a TIFF, found: " + handle->reason());
  if (directory != 0 && TIFFSetDirectory(handle->tiff_, directory) != 1)
    return bad_data(path.string() + ": directory " + std::to_string(directory) + ": " + handle->reason());
  std::uint16_t photometric = 0, compression = 0;
  TIFFGetField(handle->tiff_, TIFFTAG_PHOTOMETRIC, &photometric);
  TIFFGetField(handle->tiff_, TIFFTAG_COMPRESSION, &compression);
  if (photometric == PHOTOMETRIC_YCBCR && compression == COMPRESSION_JPEG)
    TIFFSetField(handle->tiff_, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
  return handle;
}

TiffHandle::~TiffHandle() {
  if (tiff_ != nullptr) TIFFClose(tiff_);
}

std::vector<double> TiffHandle::doubles(std::uint32_t tag) const {
  return copied<double>(values_of(tiff_, tag, TIFF_DOUBLE));
}

std::vector<std::uint16_t> TiffHandle::shorts(std::uint32_t tag) const {
  return copied<std::uint16_t>(values_of(tiff_, tag, TIFF_SHORT));
}

std::string TiffHandle::ascii(std::uint32_t tag) const {
  const auto characters = copied<char>(values_of(tiff_, tag, TIFF_ASCII));
  return {characters.begin(), std::find(characters.begin(), characters.end(), '\0')};
}

Result<std::unique_ptr<TiffHandle>> TiffHandlePool::take() {
  {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      auto handle = std::move(idle_.back());
      idle_.pop_back();
      return handle;
    }
  }
  return TiffHandle::open(path_, directory_);
}

void TiffHandlePool::give_back(std::unique_ptr<TiffHandle> handle) {
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(handle));
}

}  // namespace cairn
