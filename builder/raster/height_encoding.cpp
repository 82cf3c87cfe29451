#include "builder/raster/height_encoding.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

#include "format/simd_clones.h"

namespace cairn {
namespace {

constexpr float kVoid = std::numeric_limits<float>::quiet_NaN();

template <class T>
T load(const std::byte* at, bool swapped) {
  std::byte bytes[sizeof(T)];
  std::memcpy(bytes, at, sizeof(T));
  if (swapped) std::reverse(bytes, bytes + sizeof(T));
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

/// The file's nodata value as a sample, or a sample that is a void anyway where there is none of that type.
template <class T>
struct Nodata {
  T value = std::is_signed_v<T> && sizeof(T) > 1 ? static_cast<T>(-32768) : T{};
  bool present = std::is_signed_v<T> && sizeof(T) > 1;

  explicit Nodata(const std::optional<double>& tagged) {
    constexpr double lowest = std::numeric_limits<T>::lowest();
    constexpr double highest = std::numeric_limits<T>::max();
    if (!tagged || std::isnan(*tagged) || *tagged < lowest || *tagged > highest) return;
    if (std::is_integral_v<T> && *tagged != std::floor(*tagged)) return;
    value = static_cast<T>(*tagged);
    present = true;
  }
};

template <class T>
bool customary_void(T v) {
  if constexpr (std::is_unsigned_v<T> || sizeof(T) == 1) {
    return false;
  } else {
    return (v == T(-32768)) | (v == T(-32767)) | (v == T(-9999));
  }
}

template <class T, bool Scaled>
float integer_height(T v, const Nodata<T>& nodata, double scale, double offset) {
  const bool is_void = customary_void(v) | (nodata.present & (v == nodata.value));
  float metres = static_cast<float>(v);
  if constexpr (Scaled) metres = static_cast<float>(static_cast<double>(v) * scale + offset);
  if constexpr (Scaled || sizeof(T) > 2) {
    if (!(std::abs(metres) < static_cast<float>(kImpossibleHeight))) return kVoid;
  }
  // NaN by setting its bits: a choice would become a branch, and the loop one of single samples.
  constexpr std::uint32_t kNaN = 0x7FC00000;
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(metres) | ((0U - std::uint32_t{is_void}) & kNaN));
}

template <class T>
float floating_height(T v, double nodata, double tolerance, double scale, double offset) {
  const auto wide = static_cast<double>(v);
  const double metres = wide * scale + offset;
  const bool is_void =
      customary_void(v) || std::abs(wide - nodata) <= tolerance || !(std::abs(metres) < kImpossibleHeight);
  return is_void ? kVoid : static_cast<float>(metres);
}

template <class T>
void decode_floating(const HeightEncoding& e, const std::byte* samples, std::size_t count, std::size_t stride,
                     float* metres) {
  const double nodata = e.nodata.value_or(std::numeric_limits<double>::quiet_NaN());
  // Written in decimal and rounded to float on the way, a tag may differ from the samples it means.
  // An infinite one needs none: infinities are voids anyway.
  constexpr double kRounding = 2.0 * static_cast<double>(std::numeric_limits<float>::epsilon());
  const double tolerance = std::isinf(nodata) ? 0 : std::abs(nodata) * kRounding;
  for (std::size_t i = 0; i < count; ++i)
    metres[i] = floating_height(load<T>(samples + i * stride * sizeof(T), e.swapped), nodata, tolerance,
                                e.scale, e.offset);
}

template <class T, bool Scaled, bool Swapped>
CAIRN_SIMD_CLONES_TEMPLATE void decode_contiguous(Nodata<T> nodata, double scale, double offset,
                                                  const std::byte* samples, std::size_t count,
                                                  float* metres) {
  for (std::size_t i = 0; i < count; ++i)
    metres[i] = integer_height<T, Scaled>(load<T>(samples + i * sizeof(T), Swapped), nodata, scale, offset);
}

template <class T, bool Scaled, bool Swapped>
void decode_integers(const HeightEncoding& e, const std::byte* samples, std::size_t count, std::size_t stride,
                     float* metres) {
  const Nodata<T> nodata(e.nodata);
  if (stride == 1)
    return decode_contiguous<T, Scaled, Swapped>(nodata, e.scale, e.offset, samples, count, metres);
  for (std::size_t i = 0; i < count; ++i)
    metres[i] = integer_height<T, Scaled>(load<T>(samples + i * stride * sizeof(T), Swapped), nodata, e.scale,
                                          e.offset);
}

template <class T>
void decode(const HeightEncoding& e, const std::byte* samples, std::size_t count, std::size_t stride,
            float* metres) {
  if constexpr (std::is_floating_point_v<T>) {
    decode_floating<T>(e, samples, count, stride, metres);
  } else {
    const bool scaled = e.scale != 1 || e.offset != 0;
    if (scaled && e.swapped) return decode_integers<T, true, true>(e, samples, count, stride, metres);
    if (scaled) return decode_integers<T, true, false>(e, samples, count, stride, metres);
    if (e.swapped) return decode_integers<T, false, true>(e, samples, count, stride, metres);
    decode_integers<T, false, false>(e, samples, count, stride, metres);
  }
}

}  // namespace

bool HeightEncoding::whole_metres() const {
  const bool integers = type != SampleType::float32 && type != SampleType::float64;
  return integers && scale == std::floor(scale) && offset == std::floor(offset);
}

void decode_heights(const HeightEncoding& e, const std::byte* samples, std::size_t count, std::size_t stride,
                    float* metres) {
  switch (e.type) {
    case SampleType::uint8:
      return decode<std::uint8_t>(e, samples, count, stride, metres);
    case SampleType::int8:
      return decode<std::int8_t>(e, samples, count, stride, metres);
    case SampleType::uint16:
      return decode<std::uint16_t>(e, samples, count, stride, metres);
    case SampleType::int16:
      return decode<std::int16_t>(e, samples, count, stride, metres);
    case SampleType::uint32:
      return decode<std::uint32_t>(e, samples, count, stride, metres);
    case SampleType::int32:
      return decode<std::int32_t>(e, samples, count, stride, metres);
    case SampleType::float32:
      return decode<float>(e, samples, count, stride, metres);
    case SampleType::float64:
      return decode<double>(e, samples, count, stride, metres);
  }
}

void swap_bytes(std::byte* samples, std::size_t count, std::size_t sample_bytes) {
  if (sample_bytes == 1) return;
  for (std::size_t i = 0; i < count; ++i)
    std::reverse(samples + i * sample_bytes, samples + (i + 1) * sample_bytes);
}

}  // namespace cairn
