#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "cairn/status.h"

namespace cairn {

/// A JPEG in RGB that is written row by row beside its target, as `TARGET.part`, and renamed when whole.
class JpegWriter {
 public:
  static Result<JpegWriter> create(const std::filesystem::path& target, int columns, int rows);

  JpegWriter(JpegWriter&&) noexcept;
  JpegWriter& operator=(JpegWriter&&) noexcept;
  ~JpegWriter();  ///< removes the part where finish() was not called

  /// The next row from the top, 3 bytes a pixel.
  Status write_row(std::span<const std::uint8_t> rgb);

  /// REQUIRES: all rows are written.
  Status finish();

 private:
  struct State;
  explicit JpegWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cairn
