#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cairn/ground_query.h"
#include "cairn/pack_reader.h"
#include "cairn/surface.h"
#include "cairn/view_state.h"
#include "runtime/viewer/object_edits.h"

namespace cairn::viewer {

/// Returns the direction, geocentric, in which a picture shows a pixel; rows from the top.
glm::dvec3 direction_at(const ViewState& view, double column, double row);

/// Placing objects of a pack's models in a window, and changing those that were placed. Those that are baked
/// into the pack can be looked at only.
class ObjectEditor {
 public:
  /// Reads the pack's models and its placements. The error is that of a file that cannot be understood.
  static Result<ObjectEditor> open(std::shared_ptr<const PackReader> pack);

  const std::vector<std::shared_ptr<const ObjectModel>>& models() const { return models_; }
  const PlacedTiles& placed() const { return placed_; }
  const ObjectEdits& edits() const { return edits_; }
  std::optional<std::size_t> selected() const { return selected_; }
  /// What was done or went wrong last.
  const std::string& message() const { return message_; }

  enum class Click { selects, places, moves };
  /// What a click on the picture does. Selecting goes by what the ray `hit`; placing and moving by the ground
  /// that it meets.
  void click(Click does, std::uint16_t model, const glm::dvec3& eye, const glm::dvec3& direction,
             const std::optional<ObjectHit>& hit);
  void turn(double heading_deg);  ///< the selected one; nothing where none is
  void scale(double scale);       ///< likewise; > 0
  void remove();                  ///< likewise
  void undo();

 private:
  ObjectEditor(std::shared_ptr<const PackReader> pack, ObjectEdits edits);
  void change(const Placement& placement);
  void show(const Status& done, const std::string& what);
  std::optional<LonLat> ground_at(const glm::dvec3& eye, const glm::dvec3& direction);

  std::shared_ptr<const PackReader> pack_;
  std::unique_ptr<GroundQuery> ground_;
  ObjectEdits edits_;
  std::vector<std::shared_ptr<const ObjectModel>> models_;
  PlacedTiles placed_;
  std::optional<std::size_t> selected_;
  std::string message_;
};

}  // namespace cairn::viewer
