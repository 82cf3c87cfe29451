#include "runtime/viewer/object_editor.h"

#include <cmath>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace cairn::viewer {

glm::dvec3 direction_at(const ViewState& view, double column, double row) {
  const CameraFrame camera = camera_frame(view);
  const double high = std::tan(glm::radians(view.fov_y_deg) / 2);
  const double wide = high * view.viewport_width_px / view.viewport_height_px;
  const double x = 2 * column / view.viewport_width_px - 1, y = 1 - 2 * row / view.viewport_height_px;
  return glm::normalize(camera.forward + camera.right * (x * wide) + camera.up * (y * high));
}

ObjectEditor::ObjectEditor(std::shared_ptr<const PackReader> pack, ObjectEdits edits)
    : pack_(std::move(pack)), ground_(std::make_unique<GroundQuery>(pack_)), edits_(std::move(edits)) {}

Result<ObjectEditor> ObjectEditor::open(std::shared_ptr<const PackReader> pack) {
  Result<ObjectEdits> edits = ObjectEdits::open(placements_path(pack->path()));
  if (!edits) return edits.error();
  ObjectEditor editor(std::move(pack), std::move(*edits));
  for (std::size_t i = 0; i < editor.pack_->model_count(); ++i) {
    Result<ObjectModel> model = editor.pack_->read_model(static_cast<std::uint32_t>(i));
    if (!model) return model.error();
    editor.models_.push_back(std::make_shared<const ObjectModel>(std::move(*model)));
  }
  editor.show({}, "");
  return editor;
}

std::optional<LonLat> ObjectEditor::ground_at(const glm::dvec3& eye, const glm::dvec3& direction) {
  const Result<std::optional<GroundHit>> hit = ground_->ray(eye, direction);
  if (!hit) message_ = hit.error().message;
  if (!hit || !*hit) return std::nullopt;
  return (*hit)->at.place;
}

void ObjectEditor::click(Click does, std::uint16_t model, const glm::dvec3& eye, const glm::dvec3& direction,
                         const std::optional<ObjectHit>& hit) {
  if (does == Click::selects) {
    selected_ = hit ? placed_.placement_of(*hit) : std::nullopt;
    message_ = !hit ? "" : selected_ ? hit->model->name : hit->model->name + ": baked into the pack";
    return;
  }
  const std::optional<LonLat> place = ground_at(eye, direction);
  if (!place) return;
  if (does == Click::places) {
    const Status done = edits_.place({*place, models_[model]->name, 0, 1, {}});
    if (done) selected_ = edits_.all().size() - 1;
    show(done, "placed " + models_[model]->name);
  } else if (selected_) {
    Placement moved = edits_.all()[*selected_];
    moved.at = *place;
    change(moved);
  }
}

void ObjectEditor::change(const Placement& placement) {
  show(edits_.change(*selected_, placement), "changed " + placement.model);
}

void ObjectEditor::turn(double heading_deg) {
  if (!selected_) return;
  Placement turned = edits_.all()[*selected_];
  turned.heading_deg = heading_deg;
  change(turned);
}

void ObjectEditor::scale(double scale) {
  if (!selected_) return;
  Placement scaled = edits_.all()[*selected_];
  scaled.scale = scale;
  change(scaled);
}

void ObjectEditor::remove() {
  if (!selected_) return;
  const std::string name = edits_.all()[*selected_].model;
  const Status done = edits_.remove(*selected_);
  if (done) selected_.reset();
  show(done, "removed " + name);
}

void ObjectEditor::undo() {
  const Status done = edits_.undo();
  if (done) selected_.reset();
  show(done, "taken back");
}

void ObjectEditor::show(const Status& done, const std::string& what) {
  placed_ = placed_tiles(edits_.all(), models_, pack_->header().body);
  message_ = done ? what : done.error().message;
  if (!done || placed_.unknown.empty()) return;
  message_ += (message_.empty() ? "" : "; ") + std::string("not in the pack: ") + placed_.unknown.front();
  if (placed_.unknown.size() > 1) message_ += " and " + std::to_string(placed_.unknown.size() - 1) + " more";
}

}  // namespace cairn::viewer
