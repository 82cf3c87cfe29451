#include "runtime/viewer/panel.h"

#include <algorithm>
#include <cmath>

#include <imgui.h>

namespace cairn::viewer {

const char* const kKeysHelp =
    "W A S D    fly ahead, left, back, right (left stick)\n"
    "E Q        climb, sink (triggers)\n"
    "drag       look around, or turn around the place in the middle (right stick)\n"
    "wheel      nearer, farther\n"
    "Shift      four times as fast\n"
    "Tab        free flight or orbit\n"
    "Home       the whole pack\n"
    "T Shift+T  an hour later, earlier\n"
    "R          begin or end recording a flight\n"
    "F1 F2 F3   this help, the panel, the scene map\n"
    "F4 F5 F6   wireframe, level colours, fog\n"
    "F7         place and change objects\n"
    "M          measure: clicks make a line on the ground\n"
    "F12        screenshot\n"
    "Esc        quit";

namespace {

constexpr float kMapSide = 220;

ImU32 colour_of_level(int level) {
  const float hue = std::fmod(static_cast<float>(level + 9) * 0.381966f, 1.0f);
  return ImColor::HSV(hue, 0.55f, 0.85f, 0.8f);
}

void draw_counters(const PanelState& state, const RenderList* list) {
  const PagingStats& p = state.paging;
  ImGui::Text("%zu grids, %zu triangles", state.counts.patches, state.counts.triangles);
  ImGui::Text("%.0f MiB of tiles, %.0f MiB of textures", static_cast<double>(p.resident_bytes) / 1048576,
              static_cast<double>(state.counts.gpu_bytes) / 1048576);
  ImGui::Text("%.1f MiB on the way, %llu tiles loaded", static_cast<double>(p.in_flight_bytes) / 1048576,
              static_cast<unsigned long long>(p.tiles_loaded));
  if (p.models_loaded > 0) {
    ImGui::Text("%zu objects, %zu as billboards, %zu calls, %zu triangles", state.counts.objects,
                state.counts.billboards, state.counts.object_calls, state.counts.object_triangles);
    ImGui::Text("%llu objects and %llu models in memory (%.1f MiB)",
                static_cast<unsigned long long>(p.objects_resident),
                static_cast<unsigned long long>(p.models_resident),
                static_cast<double>(p.model_bytes) / 1048576);
  }
  if (list) {
    ImGui::Text("showing %.1f px of error, texels of %.1f px%s", list->error_px, list->texel_px,
                list->is_limited ? ", limited by the cache" : "");
  }
  ImGui::Text("latency p95 %.0f ms, %llu holes, %llu damaged", p.latency_ms.p95,
              static_cast<unsigned long long>(p.holes), static_cast<unsigned long long>(p.tiles_damaged));
  ImGui::PlotLines("##frames", state.frame_ms.data(), static_cast<int>(state.frame_ms.size()),
                   state.frame_index, "frame ms", 0, 33.3f, ImVec2(kMapSide, 50));
}

/// The tiles around the camera, as in Melkisetoğlu 2005, figures 8.5: eight of its tiles to each side.
void draw_map(const RenderList& list, const ViewState& view) {
  int finest = kMinLevel;
  for (const RenderTile& tile : list.tiles) finest = std::max(finest, tile.area.level);
  const double half = 8 * tile_width_degrees(finest);
  const ImVec2 origin = ImGui::GetCursorScreenPos();
  ImDrawList* draw = ImGui::GetWindowDrawList();
  draw->PushClipRect(origin, ImVec2(origin.x + kMapSide, origin.y + kMapSide), true);
  const auto at = [&](double lon, double lat) {
    return ImVec2(origin.x + static_cast<float>((lon - view.eye.lon + half) / (2 * half)) * kMapSide,
                  origin.y + static_cast<float>((view.eye.lat + half - lat) / (2 * half)) * kMapSide);
  };
  for (const RenderTile& tile : list.tiles) {
    const GeoBounds b = tile_bounds(tile.area);
    const ImVec2 north_west = at(b.west, b.north), south_east = at(b.east, b.south);
    draw->AddRectFilled(north_west, south_east, colour_of_level(tile.area.level));
    draw->AddRect(north_west, south_east, tile.visible ? IM_COL32_WHITE : IM_COL32(0, 0, 0, 160));
  }
  const double heading = view.heading_deg * 3.14159265358979 / 180;
  const ImVec2 eye = at(view.eye.lon, view.eye.lat);
  draw->AddCircleFilled(eye, 4, IM_COL32(255, 255, 255, 255));
  draw->AddLine(eye,
                ImVec2(eye.x + 16 * static_cast<float>(std::sin(heading)),
                       eye.y - 16 * static_cast<float>(std::cos(heading))),
                IM_COL32_WHITE, 2);
  draw->PopClipRect();
  ImGui::Dummy(ImVec2(kMapSide, kMapSide));
}

void draw_colours(PanelState& state, FrameLook& look) {
  if (ImGui::BeginCombo("tint", state.tint.empty() ? "own" : state.tint.c_str())) {
    if (ImGui::Selectable("own", state.tint.empty())) {
      state.tint.clear();
      look.tint.clear();
    }
    for (const NamedTint& tint : tints()) {
      const std::string name(tint.name);
      if (!ImGui::Selectable(name.c_str(), state.tint == name)) continue;
      state.tint = name;
      look.tint = stops_of(tint, state.heights.lowest_m, state.heights.highest_m);
    }
    ImGui::EndCombo();
  }
  float imagery = static_cast<float>(look.imagery), exposure = static_cast<float>(look.exposure_ev);
  if (ImGui::SliderFloat("imagery", &imagery, 0, 1, "%.2f")) look.imagery = static_cast<double>(imagery);
  if (ImGui::SliderFloat("exposure", &exposure, -4, 4, "%.1f")) {
    look.exposure_ev = static_cast<double>(exposure);
  }
}

void draw_sun(SunTime& sun) {
  if (!sun.utc_s) {
    float hour = static_cast<float>(sun.hour);
    if (ImGui::SliderFloat("hour", &hour, 0, 24, "%.1f")) sun.hour = static_cast<double>(hour);
    return;
  }
  ImGui::Text("%s", time_text(*sun.utc_s).c_str());
  const double day = std::floor(*sun.utc_s / 86400);
  float hour = static_cast<float>(*sun.utc_s / 3600 - day * 24);
  if (ImGui::SliderFloat("hour UTC", &hour, 0, 24, "%.2f")) {
    sun.utc_s = day * 86400 + std::min(static_cast<double>(hour), 23.999) * 3600;
  }
}

bool draw_settings(PanelState& state, FrameLook& look) {
  ImGui::Checkbox("wireframe", &look.wireframe);
  ImGui::SameLine();
  ImGui::Checkbox("levels", &look.level_colours);
  ImGui::SameLine();
  ImGui::Checkbox("fog", &look.fog);
  ImGui::SameLine();
  ImGui::Checkbox("shadows", &look.shadows);
  ImGui::SameLine();
  ImGui::Checkbox("objects", &look.objects);
  bool has_sea = look.sea_m.has_value();
  if (ImGui::Checkbox("sea at 0", &has_sea)) look.sea_m = has_sea ? std::optional(0.0) : std::nullopt;
  ImGui::SameLine();
  ImGui::Checkbox("slopes", &look.slope_colours);
  float contours = static_cast<float>(look.contours_m);
  if (ImGui::SliderFloat("contours, m", &contours, 0, 500, "%.0f")) {
    look.contours_m = static_cast<double>(contours);
  }
  draw_colours(state, look);
  draw_sun(state.sun);
  float tolerance = static_cast<float>(look.tolerance_px);
  if (ImGui::SliderFloat("pixels of error", &tolerance, 0.1f, 20, "%.1f")) {
    look.tolerance_px = std::max(0.01, static_cast<double>(tolerance));
  }
  if (ImGui::BeginCombo("mesh", look.method ? std::string(look.method->name).c_str() : "own")) {
    if (ImGui::Selectable("own", !look.method)) look.method = nullptr;
    for (const LodMethodInfo* method : lod_methods()) {
      if (ImGui::Selectable(std::string(method->name).c_str(), look.method == method)) look.method = method;
    }
    ImGui::EndCombo();
  }
  ImGui::InputScalarN("##place", ImGuiDataType_Double, state.go_to.data(), 5, nullptr, nullptr, "%.5f");
  ImGui::SameLine();
  return ImGui::Button("go");
}

void draw_measured(PanelState& state) {
  ImGui::SetNextWindowPos(ImVec2(300, 8), ImGuiCond_FirstUseEver);
  ImGui::Begin("distance", &state.measures, ImGuiWindowFlags_AlwaysAutoResize);
  ImGui::Text("%zu places, %.1f m", state.measured.size(), state.measured_m);
  state.saves_profile = state.measured.size() > 1 && ImGui::Button("save the profile");
  if (!state.measured.empty() && ImGui::Button("clear")) state.measured.clear();
  ImGui::End();
}

void draw_status_line(const std::string& text) {
  const ImGuiIO& io = ImGui::GetIO();
  ImGui::SetNextWindowPos(ImVec2(io.DisplaySize.x - 8, io.DisplaySize.y - 8), ImGuiCond_Always, ImVec2(1, 1));
  ImGui::Begin("##status", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoInputs |
                   ImGuiWindowFlags_NoFocusOnAppearing);
  ImGui::TextUnformatted(text.c_str());
  ImGui::End();
}

}  // namespace

void draw_object_editor(PanelState& state, ObjectEditor& editor) {
  ImGui::SetNextWindowPos(ImVec2(300, 8), ImGuiCond_FirstUseEver);
  ImGui::Begin("objects", &state.shows_objects, ImGuiWindowFlags_AlwaysAutoResize);
  using Click = ObjectEditor::Click;
  ImGui::TextUnformatted("a click");
  for (const auto& [name, does] :
       {std::pair("selects", Click::selects), {"places", Click::places}, {"moves", Click::moves}}) {
    ImGui::SameLine();
    if (ImGui::RadioButton(name, state.click == does)) state.click = does;
  }
  state.model = std::clamp(state.model, 0, static_cast<int>(editor.models().size()) - 1);
  const auto name_of = [&](int i) { return editor.models()[static_cast<std::size_t>(i)]->name.c_str(); };
  if (ImGui::BeginCombo("model", name_of(state.model))) {
    for (int i = 0; i < static_cast<int>(editor.models().size()); ++i) {
      ImGui::PushID(i);
      if (ImGui::Selectable(name_of(i), i == state.model)) state.model = i;
      ImGui::PopID();
    }
    ImGui::EndCombo();
  }
  if (const auto selected = editor.selected()) {
    const Placement& placement = editor.edits().all()[*selected];
    ImGui::Text("%s at %.6f, %.6f", placement.model.c_str(), placement.at.lon, placement.at.lat);
    double heading = placement.heading_deg, scale = placement.scale;
    const auto flags = ImGuiInputTextFlags_EnterReturnsTrue;
    if (ImGui::InputDouble("heading", &heading, 5, 45, "%.1f", flags)) editor.turn(heading);
    if (ImGui::InputDouble("scale", &scale, 0.05, 0.5, "%.2f", flags) && scale > 0) editor.scale(scale);
    if (ImGui::Button("delete")) editor.remove();
    ImGui::SameLine();
  }
  if (editor.edits().can_undo() && ImGui::Button("undo")) editor.undo();
  ImGui::Text("%zu placed", editor.edits().all().size());
  if (!editor.message().empty()) ImGui::TextWrapped("%s", editor.message().c_str());
  ImGui::End();
}

std::optional<std::array<double, 5>> draw_panel(PanelState& state, FrameLook& look, const ViewState& view,
                                                const RenderList* list) {
  bool goes = false;
  if (state.shows_panel) {
    ImGui::SetNextWindowPos(ImVec2(8, 8), ImGuiCond_FirstUseEver);
    ImGui::Begin("cairn", &state.shows_panel, ImGuiWindowFlags_AlwaysAutoResize);
    ImGui::Text("%.6f, %.6f, %.1f m", view.eye.lon, view.eye.lat, view.height_m);
    ImGui::Text("heading %.1f, pitch %.1f", std::fmod(view.heading_deg + 360, 360), view.pitch_deg);
    draw_counters(state, list);
    goes = draw_settings(state, look);
    if (state.shows_map && list) draw_map(*list, view);
    if (!state.message.empty()) ImGui::TextWrapped("%s", state.message.c_str());
    ImGui::TextDisabled("F1: keys");
    ImGui::End();
  }
  if (state.measures) draw_measured(state);
  if (!state.under_cursor.empty()) draw_status_line(state.under_cursor);
  if (state.shows_help) {
    ImGui::SetNextWindowPos(ImVec2(300, 40), ImGuiCond_FirstUseEver);
    ImGui::Begin("keys", &state.shows_help, ImGuiWindowFlags_AlwaysAutoResize);
    ImGui::TextUnformatted(kKeysHelp);
    ImGui::End();
  }
  return goes ? std::optional(state.go_to) : std::nullopt;
}

}  // namespace cairn::viewer
