#include "format/object_rules.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "cairn/pack_sampler.h"
#include "format/pack_rules.h"

namespace cairn {
namespace {

/// Adds findings about one entry.
class EntryFindings {
 public:
  EntryFindings(const IndexEntry& entry, std::vector<Finding>& findings)
      : entry_(entry), findings_(findings) {}

  void add(const std::string& what, const std::string& expected, const std::string& found) {
    findings_.push_back({std::string(to_string(entry_.layer)) + " " + to_string(entry_.id),
                         what + ": expected " + expected + ", found " + found});
  }

 private:
  const IndexEntry& entry_;
  std::vector<Finding>& findings_;
};

// One finding a tile, for the first object that breaks a rule.
void check_sizes(const PackReader& pack, const IndexEntry& entry, const ObjectTile& tile,
                 EntryFindings& findings) {
  std::optional<std::uint16_t> model;
  double size = 0;
  for (std::size_t i = 0; i < tile.objects.size(); ++i) {
    const PlacedObject& object = tile.objects[i];
    if (model != object.model) {
      const auto found = pack.find(Layer::models, model_address(object.model));
      if (!found)
        return findings.add("object " + std::to_string(i), "a model of the pack",
                            "number " + std::to_string(object.model));
      model = object.model;
      size = static_cast<double>(found->geometric_error_m);
    }
    const double scaled = size * object.scale_factor();
    const int level = object_level(scaled, pack.header().body);
    const int coarsest = pack.levels(Layer::objects)->coarsest;
    if (entry.id.level != std::max(level, coarsest))
      return findings.add("object " + std::to_string(i),
                          "one of level " + std::to_string(entry.id.level) + " by its size",
                          "one of level " + std::to_string(level));
    if (scaled > static_cast<double>(entry.geometric_error_m))
      return findings.add("object " + std::to_string(i),
                          "a size of at most " + std::to_string(entry.geometric_error_m) + " m",
                          std::to_string(scaled) + " m");
  }
}

void check_feet(const PackReader& pack, const IndexEntry& entry, const ObjectTile& tile,
                EntryFindings& findings) {
  PackSampler ground(pack);
  std::int64_t lowest = std::numeric_limits<std::int64_t>::max();
  std::int64_t highest = std::numeric_limits<std::int64_t>::min();
  for (std::size_t i = 0; i < tile.objects.size(); ++i) {
    const auto height = ground.height_at(place_of(entry.id, tile.objects[i]));
    if (!height) return;  // the tile of heights is a finding of its own
    if (!*height) return findings.add("object " + std::to_string(i), "ground beneath it", "a void");
    const std::int64_t foot = foot_quanta(tile.objects[i], (*height)->metres, pack.header().quantum_m);
    lowest = std::min(lowest, foot);
    highest = std::max(highest, foot);
  }
  if (lowest != tile.lowest_quanta)
    findings.add("lowest foot", std::to_string(lowest) + " as on the ground",
                 std::to_string(tile.lowest_quanta));
  if (highest != tile.highest_quanta)
    findings.add("highest foot", std::to_string(highest) + " as on the ground",
                 std::to_string(tile.highest_quanta));
}

}  // namespace

void check_object_tile(const PackReader& pack, const IndexEntry& entry, std::vector<Finding>& findings) {
  EntryFindings own(entry, findings);
  const Result<ObjectTile> tile = pack.read_object_tile(entry);
  if (!tile) {
    findings.push_back(finding_from(pack, entry, tile.error()));
    return;
  }
  const std::size_t stated = static_cast<std::size_t>(std::max(entry.min_quanta, 0));
  if (entry.min_quanta < 0 || stated != tile->objects.size())
    own.add("objects", std::to_string(tile->objects.size()) + " as the block has",
            std::to_string(entry.min_quanta));
  if (tile->objects.empty()) return;
  check_sizes(pack, entry, *tile, own);
  check_feet(pack, entry, *tile, own);
}

void check_model(const PackReader& pack, const IndexEntry& entry, std::vector<Finding>& findings) {
  EntryFindings own(entry, findings);
  const auto number = static_cast<std::uint32_t>(entry.id.x);
  if (entry.id != model_address(number) || number >= pack.model_count() || number >= kMostModels) {
    own.add("address", "9/0/0 to 9/" + std::to_string(pack.model_count() - 1) + "/0", to_string(entry.id));
    return;
  }
  const Result<ObjectModel> model = pack.read_model(number);
  if (!model) {
    findings.push_back(finding_from(pack, entry, model.error()));
    return;
  }
  const std::size_t triangles = model->levels.empty() ? 0 : model->levels[0].count / 3;
  if (entry.min_quanta < 0 || static_cast<std::size_t>(entry.min_quanta) != triangles)
    own.add("triangles", std::to_string(triangles) + " as the block has", std::to_string(entry.min_quanta));
  if (entry.geometric_error_m != model->size_m())
    own.add("size", std::to_string(model->size_m()) + " m as the block has",
            std::to_string(entry.geometric_error_m) + " m");
}

}  // namespace cairn
