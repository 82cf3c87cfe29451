#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "cairn/status.h"
#include "cairn/view_state.h"
#include "runtime/flight/camera_text.h"

namespace cairn::stream {

/// What a viewer keeps pressed, each from -1 to 1, and the factor on the usual speed, above 0 and at most 10.
struct HeldKeys {
  double ahead = 0;
  double aside = 0;
  double climb = 0;
  double speed = 1;
};

/// One message of a viewer; what it does not name stays as it is.
struct ViewerMessage {
  std::optional<viewer::Size> size;    ///< of the picture, 64x64 to 1920x1080
  std::optional<ViewState> camera;     ///< its place, height, heading and pitch
  bool home = false;                   ///< the pack's bounds fill the view
  std::optional<double> hour;          ///< local solar time, 0 to 24
  std::optional<HeldKeys> held;        ///< until the next message that has it
  double turn_deg = 0;                 ///< by which a drag turned the view to the right
  double tilt_deg = 0;                 ///< up
  double zoom_steps = 0;               ///< nearer
  std::optional<std::uint64_t> input;  ///< a number that frames repeat which show this message's effect
  std::optional<std::uint64_t> shown;  ///< the last frame that the viewer has shown
};

/// bad_data: "viewer: FIELD: expected …, found …".
Result<ViewerMessage> parse_viewer_message(std::string_view text);

/// What is said of a frame beside its picture.
struct FrameNote {
  std::uint64_t frame = 0;  ///< counts from 1
  std::uint64_t input = 0;  ///< the last one that was applied
  ViewState view;
  double draw_ms = 0;
  double encode_ms = 0;
  bool is_complete = false;  ///< whether all that the view needs was there
  double error_px = 0;       ///< by which the ground may be off
};

/// Returns a message to a viewer: the bytes of a JSON object's length, little-endian, in 32 bits, the object,
/// and the picture as JPEG; no picture where the last one still holds.
std::string frame_message(const FrameNote& note, std::string_view jpeg);

}  // namespace cairn::stream
