#include "runtime/stream/jpeg_encoder.h"

#include <string>

#include <turbojpeg.h>

namespace cairn::stream {

JpegEncoder::JpegEncoder() : compressor_(::tjInitCompress()) {}

JpegEncoder::~JpegEncoder() {
  ::tjFree(bytes_);
  if (compressor_ != nullptr) ::tjDestroy(compressor_);
}

Result<std::string_view> JpegEncoder::encode(const gl::Picture& picture, int quality) {
  if (compressor_ == nullptr) return failed("JPEG: expected an encoder, found none");
  if (::tjCompress2(compressor_, picture.rgb.data(), picture.width, 0, picture.height, TJPF_RGB, &bytes_,
                    &size_, TJSAMP_420, quality, TJFLAG_FASTDCT) != 0)
    return failed(std::string("JPEG: ") + ::tjGetErrorStr2(compressor_));
  return std::string_view(reinterpret_cast<const char*>(bytes_), size_);
}

}  // namespace cairn::stream
