#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include <epoxy/gl.h>

#include "runtime/gl/software_driver.h"

namespace cairn::gl {

/// Measures pictures by the GPU's clock, and never waits for it: a result is that of an earlier picture. By
/// time stamps, which a host's own time queries do not disturb. On a software driver, whose stamps lie where
/// it begins its own work, nothing is measured.
class GpuTimer {
 public:
  GpuTimer() { glCreateQueries(GL_TIMESTAMP, static_cast<GLsizei>(names_.size()), names_.data()); }
  GpuTimer(const GpuTimer&) = delete;
  GpuTimer& operator=(const GpuTimer&) = delete;
  ~GpuTimer() { glDeleteQueries(static_cast<GLsizei>(names_.size()), names_.data()); }

  void begin() {
    collect();
    if (begun_ - collected_ < kPairs) glQueryCounter(first_of(begun_), GL_TIMESTAMP);
  }
  void end() {
    if (begun_ - collected_ >= kPairs) return;
    glQueryCounter(second_of(begun_), GL_TIMESTAMP);
    ++begun_;
  }
  /// Of the last picture that the GPU has finished.
  std::optional<double> ms() const { return is_software_ ? std::nullopt : ms_; }

 private:
  static constexpr std::size_t kPairs = 4;
  GLuint first_of(std::size_t i) const { return names_[2 * (i % kPairs)]; }
  GLuint second_of(std::size_t i) const { return names_[2 * (i % kPairs) + 1]; }

  void collect() {
    while (collected_ < begun_) {
      GLint is_there = 0;
      glGetQueryObjectiv(second_of(collected_), GL_QUERY_RESULT_AVAILABLE, &is_there);
      if (!is_there) return;
      GLuint64 from = 0, to = 0;
      glGetQueryObjectui64v(first_of(collected_), GL_QUERY_RESULT, &from);
      glGetQueryObjectui64v(second_of(collected_), GL_QUERY_RESULT, &to);
      ms_ = static_cast<double>(to - from) * 1e-6;
      ++collected_;
    }
  }

  bool is_software_ = draws_in_software();
  std::array<GLuint, 2 * kPairs> names_{};
  std::size_t begun_ = 0;
  std::size_t collected_ = 0;
  std::optional<double> ms_;
};

}  // namespace cairn::gl
