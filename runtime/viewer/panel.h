#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "cairn/render_list.h"
#include "runtime/paging/frame_stats.h"
#include "runtime/viewer/object_editor.h"
#include "runtime/viewer/scene.h"

namespace cairn::viewer {

/// What the panel shows and lets the user change. Plain data; draw_panel is the only one that knows ImGui.
struct PanelState {
  bool shows_panel = true;
  bool shows_help = false;
  bool shows_map = true;
  bool shows_objects = false;
  SunTime sun;
  std::string tint;     ///< the name of the table; empty: the body's own
  HeightRange heights;  ///< of the pack
  std::string message;  ///< the latest error or what was just saved

  FrameCounts counts;
  PagingStats paging;
  std::array<float, 240> frame_ms{};  ///< a ring
  int frame_index = 0;
  ObjectEditor::Click click = ObjectEditor::Click::selects;  ///< what a click on the picture does
  int model = 0;                                             ///< that a click places

  std::array<double, 5> go_to{};  ///< longitude, latitude, height, heading, pitch, as typed

  std::string under_cursor;  ///< the place and the height there; empty: none is
  bool measures = false;     ///< clicks on the picture add places to `measured`
  std::vector<LonLat> measured;
  double measured_m = 0;       ///< the length of the line through them
  bool saves_profile = false;  ///< the user has asked for it in this frame
};

/// Draws what is done with objects, in a window of its own: which model, what a click does, the selected
/// one's heading and scale.
void draw_object_editor(PanelState& state, ObjectEditor& editor);

/// Draws the panel, the help and the scene map with Dear ImGui, between its NewFrame and Render. Returns the
/// place to go to when the user has asked for it: longitude, latitude, height, heading, pitch.
std::optional<std::array<double, 5>> draw_panel(PanelState& state, FrameLook& look, const ViewState& view,
                                                const RenderList* list);

/// The keys, a line each, as F1 and --help show them.
extern const char* const kKeysHelp;

}  // namespace cairn::viewer
