#include "format/codec.h"

namespace cairn {

const HeightCodec* find_height_codec(std::uint8_t id) {
  for (const HeightCodec* codec : height_codecs()) {
    if (codec->id == id) return codec;
  }
  return nullptr;
}

}  // namespace cairn
