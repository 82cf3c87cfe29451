#include "runtime/stream/stream_session.h"

#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>

namespace cairn::stream {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr std::uint64_t kFramesUnderWay = 2;
constexpr milliseconds kFrameTime{33};
constexpr milliseconds kRest{500};      // between frames where nothing moves
constexpr double kLongestStep_s = 0.1;  // that a stall may move the eye
constexpr int kFramesToRest = 3;
constexpr int kQuality = 80;
constexpr double kMovingTolerance_px = 3;  // fewer triangles, so more frames

double ms_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

bool moves(const viewer::ControlInput& input) {
  return input.ahead != 0 || input.aside != 0 || input.climb != 0 || input.turn_deg != 0 ||
         input.tilt_deg != 0 || input.zoom_steps != 0;
}

}  // namespace

StreamSession::StreamSession(const viewer::Options& options, viewer::Scene scene,
                             const viewer::FrameLook& look, const ViewState& view)
    : scene_(std::move(scene)),
      look_(look),
      view_(view),
      hour_(options.hour),
      samples_(options.samples),
      last_frame_(Clock::now()) {}

bool StreamSession::may_send() const {
  return sent_ < shown_ + kFramesUnderWay;
}

milliseconds StreamSession::patience() const {
  if (!may_send()) return kRest;
  const bool rests =
      equal_frames_ >= kFramesToRest && scene_.list() && scene_.list()->is_complete && !moves(input_);
  if (rests) return kRest;
  const auto passed = std::chrono::duration_cast<milliseconds>(Clock::now() - last_frame_);
  return std::clamp(kFrameTime - passed, milliseconds(0), kFrameTime);
}

Status StreamSession::run(StreamSocket& socket) {
  if (const Status made = set_size({view_.viewport_width_px, view_.viewport_height_px}); !made) return made;
  while (true) {
    const auto messages = socket.receive(patience());
    if (!messages) return {};
    for (const std::string& text : *messages) {
      const auto message = parse_viewer_message(text);
      const Status applied = message ? apply(*message) : Status(message.error());
      if (applied) continue;
      socket.close(applied.error().message);
      return message ? applied : Status{};
    }
    if (!messages->empty()) equal_frames_ = 0;
    if (!may_send() || Clock::now() < last_frame_ + kFrameTime) continue;
    if (const Status drawn = draw_frame(socket); !drawn) {
      socket.close(drawn.error().message);
      return drawn;
    }
  }
}

Status StreamSession::set_size(viewer::Size size) {
  auto target = gl::FrameTarget::create(size.width, size.height, samples_);
  if (!target) return target.error();
  target_ = std::move(*target);
  view_.viewport_width_px = size.width;
  view_.viewport_height_px = size.height;
  return {};
}

Status StreamSession::apply(const ViewerMessage& message) {
  if (message.size &&
      (message.size->width != target_->width() || message.size->height != target_->height())) {
    if (const Status made = set_size(*message.size); !made) return made;
  }
  const viewer::Size size{view_.viewport_width_px, view_.viewport_height_px};
  if (message.home) view_ = viewer::start_view(scene_.pack(), view_.fov_y_deg, size);
  if (message.camera) {
    view_.eye = message.camera->eye;
    view_.height_m = message.camera->height_m;
    view_.heading_deg = message.camera->heading_deg;
    view_.pitch_deg = message.camera->pitch_deg;
  }
  if (message.home || message.camera) scene_.cut();
  if (message.hour) hour_ = *message.hour;
  if (message.held) {
    input_.ahead = message.held->ahead;
    input_.aside = message.held->aside;
    input_.climb = message.held->climb;
    input_.speed = message.held->speed;
  }
  input_.turn_deg += message.turn_deg;
  input_.tilt_deg += message.tilt_deg;
  input_.zoom_steps += message.zoom_steps;
  if (message.input) input_number_ = *message.input;
  if (message.shown) shown_ = std::clamp(*message.shown, shown_, sent_);
  return {};
}

Status StreamSession::draw_frame(StreamSocket& socket) {
  const auto begin = Clock::now();
  const double since_last_s = std::chrono::duration<double>(begin - last_frame_).count();
  const double dt_s = std::min(since_last_s, kLongestStep_s);
  last_frame_ = begin;
  viewer::FrameLook look = look_;
  if (moves(input_)) look.tolerance_px = std::max(look.tolerance_px, kMovingTolerance_px);
  // What the ground is, is known from the first frame on.
  if (scene_.list()) view_ = controls_.update(view_, input_, dt_s, scene_.ground_m(view_.eye));
  input_.turn_deg = input_.tilt_deg = input_.zoom_steps = 0;
  look.to_sun = viewer::sun_direction(view_.eye, hour_);
  look.frame_s = since_last_s;
  scene_.draw(view_, dt_s, look, target_->framebuffer());
  for (const Error& error : scene_.take_errors()) std::fprintf(stderr, "%s\n", error.message.c_str());
  gl::Picture picture = target_->read();
  FrameNote note{sent_ + 1,
                 input_number_,
                 view_,
                 ms_since(begin),
                 0,
                 scene_.list()->is_complete,
                 scene_.list()->error_px};
  const bool is_new = picture.width != last_picture_.width || picture.rgb != last_picture_.rgb;
  equal_frames_ = is_new ? 0 : equal_frames_ + 1;
  if (!is_new && answered_input_ == input_number_ && was_complete_ == note.is_complete) return {};
  std::string_view jpeg;
  if (is_new) {
    const auto encoding = Clock::now();
    const auto encoded = encoder_.encode(picture, kQuality);
    if (!encoded) return encoded.error();
    jpeg = *encoded;
    note.encode_ms = ms_since(encoding);
    last_picture_ = std::move(picture);
  }
  answered_input_ = input_number_;
  was_complete_ = note.is_complete;
  ++sent_;
  socket.send(frame_message(note, jpeg));
  return {};
}

}  // namespace cairn::stream
