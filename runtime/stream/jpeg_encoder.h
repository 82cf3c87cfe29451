#pragma once

#include <memory>
#include <string_view>

#include "cairn/status.h"
#include "runtime/gl/picture.h"

namespace cairn::stream {

/// Compresses pictures as JPEG, with half the resolution of colour. One thread at a time.
class JpegEncoder {
 public:
  JpegEncoder();
  ~JpegEncoder();

  /// Returns the picture's bytes, which hold until the next call. `quality` is 1 to 100.
  Result<std::string_view> encode(const gl::Picture& picture, int quality);

 private:
  void* compressor_ = nullptr;
  unsigned char* bytes_ = nullptr;  // grown by the library
  unsigned long size_ = 0;
};

}  // namespace cairn::stream
