#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "cairn/status.h"

namespace cairn {

/// A PNG that is written row by row beside its target, as `TARGET.part`, and renamed when whole.
class PngWriter {
 public:
  enum class Pixel { rgba8, grey16 };  ///< RGBA not premultiplied; grey in the machine's byte order

  static Result<PngWriter> create(const std::filesystem::path& target, int columns, int rows, Pixel pixel);

  PngWriter(PngWriter&&) noexcept;
  PngWriter& operator=(PngWriter&&) noexcept;
  ~PngWriter();  ///< removes the part where finish() was not called

  /// The next row from the top.
  Status write_row(std::span<const std::byte> row);

  /// REQUIRES: all rows are written.
  Status finish();

 private:
  struct State;
  explicit PngWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cairn
