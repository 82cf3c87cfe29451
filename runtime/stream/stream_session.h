#pragma once

#include <chrono>
#include <optional>

#include "cairn/status.h"
#include "runtime/gl/frame_target.h"
#include "runtime/stream/jpeg_encoder.h"
#include "runtime/stream/stream_message.h"
#include "runtime/stream/stream_socket.h"
#include "runtime/viewer/camera_controls.h"
#include "runtime/viewer/scene.h"

namespace cairn::stream {

/// Draws what one viewer sees, as its messages steer: within a pixel while the eye rests, within three while
/// it moves. At most two frames are on their way that the viewer has not shown: where the network is slow
/// there are fewer frames, each of the newest state, and none is late. A frame is sent only where its
/// picture, the input that it answers or its completeness is new. OpenGL's context has to be current.
class StreamSession {
 public:
  StreamSession(const viewer::Options& options, viewer::Scene scene, const viewer::FrameLook& look,
                const ViewState& view);

  /// Runs until the viewer is gone. An error is of the driver; what a viewer sends that is malformed ends the
  /// connection and is told there.
  Status run(StreamSocket& socket);

 private:
  Status apply(const ViewerMessage& message);
  Status set_size(viewer::Size size);
  Status draw_frame(StreamSocket& socket);
  std::chrono::milliseconds patience() const;
  bool may_send() const;

  viewer::Scene scene_;
  viewer::FrameLook look_;
  ViewState view_;
  viewer::CameraControls controls_;
  viewer::ControlInput input_;  // since the last frame
  double hour_;
  int samples_;
  std::optional<gl::FrameTarget> target_;
  JpegEncoder encoder_;
  gl::Picture last_picture_;
  std::chrono::steady_clock::time_point last_frame_;
  std::uint64_t sent_ = 0;            // frames
  std::uint64_t shown_ = 0;           // of them, by the viewer
  std::uint64_t input_number_ = 0;    // of the last message with one
  std::uint64_t answered_input_ = 0;  // the last one that a frame has repeated
  bool was_complete_ = false;         // as the last frame said
  int equal_frames_ = 0;              // since the picture last changed
};

}  // namespace cairn::stream
