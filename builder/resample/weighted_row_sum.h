#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace cairn {

/// Rows of numbers in memory.
template <class T>
struct Rows {
  T* data = nullptr;
  std::ptrdiff_t stride = 0;  ///< elements from a row to the next

  T* row(std::ptrdiff_t k) const { return data + k * stride; }
};

/// out[c] = Σ weights[k] · in.row(k)[c], c < width, summed in double from k = 0 on without fused
/// multiply-add, and rounded once. Wide instructions are used where the CPU has them; the result is the same.
void weighted_row_sum(std::span<const double> weights, Rows<const double> in, std::size_t width, double* out);
void weighted_row_sum(std::span<const double> weights, Rows<const double> in, std::size_t width, float* out);

/// The same by the instructions that every x86-64 CPU has.
void weighted_row_sum_portable(std::span<const double> weights, Rows<const double> in, std::size_t width,
                               double* out);
void weighted_row_sum_portable(std::span<const double> weights, Rows<const double> in, std::size_t width,
                               float* out);

}  // namespace cairn
