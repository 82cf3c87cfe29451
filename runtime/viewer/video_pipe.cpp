#include "runtime/viewer/video_pipe.h"

#include <csignal>
#include <sstream>

namespace cairn::viewer {

void VideoPipe::Close::operator()(std::FILE* pipe) const {
  ::pclose(pipe);
}

Result<VideoPipe> VideoPipe::open(const std::filesystem::path& path, int width, int height,
                                  double frames_per_second) {
  if (path.string().find('\'') != std::string::npos) {
    return usage_error("--video: expected a name without a quote, found " + path.string());
  }
  std::signal(SIGPIPE, SIG_IGN);  // an ffmpeg that ends early is an error, not the end of us
  std::ostringstream command;
  command << "ffmpeg -loglevel error -y -f rawvideo -pix_fmt rgb24 -s " << width << 'x' << height << " -r "
          << frames_per_second << " -i - -pix_fmt yuv420p '" << path.string() << '\'';
  VideoPipe video;
  video.path_ = path;
  video.pipe_.reset(::popen(command.str().c_str(), "w"));
  if (!video.pipe_)
    return failed(path.string() + ": video: expected to start ffmpeg, found that it cannot be");
  return video;
}

Status VideoPipe::add(const gl::Picture& picture) {
  if (std::fwrite(picture.rgb.data(), 1, picture.rgb.size(), pipe_.get()) == picture.rgb.size()) return {};
  return failed(path_.string() + ": video: expected ffmpeg to take a frame, found that it has ended");
}

Status VideoPipe::finish() {
  if (::pclose(pipe_.release()) == 0) return {};
  return failed(path_.string() + ": video: expected ffmpeg to end well, found that it did not");
}

}  // namespace cairn::viewer
