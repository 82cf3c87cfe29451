#include "format/codec.h"

namespace cairn {

extern const HeightCodec wavefront_codec;

const HeightCodec& default_height_codec() {
  return wavefront_codec;
}

const HeightCodec* find_height_codec(std::uint8_t id) {
  for (const HeightCodec* codec : height_codecs()) {
    if (codec->id == id) return codec;
  }
  return nullptr;
}

}  // namespace cairn
