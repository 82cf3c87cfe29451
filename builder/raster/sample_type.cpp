#include "builder/raster/sample_type.h"

#include <array>

namespace cairn {

const char* to_string(SampleType type) {
  constexpr std::array names = {"uint8", "int8", "uint16", "int16", "uint32", "int32", "float32", "float64"};
  return names[static_cast<std::size_t>(type)];
}

std::size_t size_of(SampleType type) {
  switch (type) {
    case SampleType::uint8:
    case SampleType::int8:
      return 1;
    case SampleType::uint16:
    case SampleType::int16:
      return 2;
    case SampleType::uint32:
    case SampleType::int32:
    case SampleType::float32:
      return 4;
    case SampleType::float64:
      return 8;
  }
  return 0;
}

}  // namespace cairn
