#pragma once

#include "builder/texture_encode/kernels.h"

// What the kernel files define, one a file.

namespace cairn::CAIRN_ISA {

void encode_bc1_fast(const std::uint8_t* texels, std::ptrdiff_t stride, std::byte* out,
                     std::ptrdiff_t out_stride);
void encode_bc1_normal(const std::uint8_t* texels, std::ptrdiff_t stride, std::byte* out,
                       std::ptrdiff_t out_stride);
void encode_bc1_best(const std::uint8_t* texels, std::ptrdiff_t stride, std::byte* out,
                     std::ptrdiff_t out_stride);
void encode_bc1_best_four(const std::uint8_t* texels, std::ptrdiff_t stride, std::byte* out,
                          std::ptrdiff_t out_stride);
void encode_alpha_fast(const std::uint8_t* texels, std::ptrdiff_t stride, std::byte* out,
                       std::ptrdiff_t out_stride);
void encode_alpha_normal(const std::uint8_t* texels, std::ptrdiff_t stride, std::byte* out,
                         std::ptrdiff_t out_stride);
void bc1_errors(const std::uint8_t* texels, std::ptrdiff_t stride, const std::byte* blocks,
                std::uint32_t* errors);

void encode_bc7_fast(const std::uint8_t* texels, std::ptrdiff_t stride, std::byte* out,
                     std::ptrdiff_t out_stride);
void encode_bc7_normal(const std::uint8_t* texels, std::ptrdiff_t stride, std::byte* out,
                       std::ptrdiff_t out_stride);
void encode_bc7_best(const std::uint8_t* texels, std::ptrdiff_t stride, std::byte* out,
                     std::ptrdiff_t out_stride);

}  // namespace cairn::CAIRN_ISA
