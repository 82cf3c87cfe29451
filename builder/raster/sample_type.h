#pragma once

#include <cstddef>

namespace cairn {

/// The type of a raster's posts or pixels as the file stores them.
enum class SampleType { uint8, int8, uint16, int16, uint32, int32, float32, float64 };

/// The type's name, "int16".
const char* to_string(SampleType type);

/// Bytes of one sample.
std::size_t size_of(SampleType type);

}  // namespace cairn
