#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>

#include "cairn/status.h"
#include "runtime/gl/picture.h"

namespace cairn::viewer {

/// Frames that the program ffmpeg, if it is installed, makes a film of.
class VideoPipe {
 public:
  /// usage where the name holds a quote, which it cannot be given with.
  static Result<VideoPipe> open(const std::filesystem::path& path, int width, int height,
                                double frames_per_second);
  Status add(const gl::Picture& picture);
  /// Waits for ffmpeg; failed where it was not found or was not content.
  Status finish();

 private:
  struct Close {
    void operator()(std::FILE* pipe) const;
  };
  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Close> pipe_;
};

}  // namespace cairn::viewer
