#include "builder/export/object_tileset.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "builder/export/object_glb.h"
#include "builder/export/texture_file.h"
#include "cairn/object_tile.h"
#include "cairn/pack_sampler.h"

namespace cairn {
namespace {

using TreeJson = nlohmann::ordered_json;

constexpr int kLevelsOfFile = 4;
constexpr double kSizesOfError = 4;
constexpr double kRadiansPerDegree = std::numbers::pi / 180;

/// What a tile's volume has to hold.
struct Volume {
  GeoBounds bounds{180, 90, -180, -90};
  double lowest_m = 1e9;
  double highest_m = -1e9;

  void add(const Volume& other) {
    bounds = {std::min(bounds.west, other.bounds.west), std::min(bounds.south, other.bounds.south),
              std::max(bounds.east, other.bounds.east), std::max(bounds.north, other.bounds.north)};
    lowest_m = std::min(lowest_m, other.lowest_m);
    highest_m = std::max(highest_m, other.highest_m);
  }
  std::array<double, 6> region() const {
    return {std::max(bounds.west, -180.0) * kRadiansPerDegree,
            std::max(bounds.south, -90.0) * kRadiansPerDegree,
            std::min(bounds.east, 180.0) * kRadiansPerDegree,
            std::min(bounds.north, 90.0) * kRadiansPerDegree,
            lowest_m,
            highest_m};
  }
};

struct ObjectNode {
  TileId id;
  Volume volume;
  double error_m = 0;
  bool has_content = false;
  std::vector<ObjectNode> children;
};

std::string file_of(const TileId& id) {
  return fmt::format("{}/{}/{}", id.level, id.x, id.y);
}

class ObjectTilesetWriter {
 public:
  ObjectTilesetWriter(const PackReader& pack, const std::optional<GeoBounds>& region,
                      const VerticalShift& shift, const ExportFolder& folder)
      : pack_(pack), region_(region), shift_(shift), folder_(folder), sampler_(pack) {}

  Result<std::optional<ObjectTileset>> run() {
    const auto levels = pack_.levels(Layer::objects);
    std::vector<ObjectNode> roots;
    for (std::size_t i = 0; levels && i < pack_.entry_count(); ++i) {
      const IndexEntry entry = pack_.entry(i);
      if (entry.layer != Layer::objects || entry.id.level != levels->coarsest) continue;
      auto node = node_of(entry);
      if (!node) return node.error();
      if (*node) roots.push_back(std::move(**node));
      found_.error_m = std::max(found_.error_m, kSizesOfError * static_cast<double>(entry.geometric_error_m));
    }
    if (roots.empty()) return std::optional<ObjectTileset>();
    ObjectNode root;
    for (const ObjectNode& node : roots) root.volume.add(node.volume);
    root.error_m = found_.error_m;
    root.children = std::move(roots);
    if (auto status = write_tree(root, "tileset", ""); !status) return status.error();
    found_.region = root.volume.region();
    found_.models = models_.size();
    return std::optional(found_);
  }

 private:
  /// Nothing where no object of the tile or beneath it is in the region.
  Result<std::optional<ObjectNode>> node_of(const IndexEntry& entry) {
    ObjectNode node;
    node.id = entry.id;
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      const TileId id{entry.id.level + 1, 2 * entry.id.x + (quadrant & 1), 2 * entry.id.y + (quadrant >> 1)};
      const auto child = pack_.find(Layer::objects, id);
      if (!child) continue;
      auto below = node_of(*child);
      if (!below) return below.error();
      if (!*below) continue;
      node.error_m = std::max(node.error_m, kSizesOfError * static_cast<double>(child->geometric_error_m));
      node.volume.add((*below)->volume);
      node.children.push_back(std::move(**below));
    }
    if ((entry.flags & kConstant) == 0) {
      if (auto status = write_content(entry, node); !status) return status.error();
    }
    if (!node.has_content && node.children.empty()) return std::optional<ObjectNode>();
    return std::optional(std::move(node));
  }

  Status write_content(const IndexEntry& entry, ObjectNode& node) {
    const auto tile = pack_.read_object_tile(entry);
    if (!tile) return tile.error();
    std::vector<ModelInstances> models;
    for (const PlacedObject& object : tile->objects) {
      const LonLat at = place_of(entry.id, object);
      if (!is_in_region(at)) continue;
      const auto model = model_of(object.model);
      if (!model) return model.error();
      if (models.empty() || models.back().model != &(*model)->buffer)
        models.push_back({&(*model)->buffer, {}});
      if (auto status = add_instance(object, at, **model, models.back(), node.volume); !status) return status;
    }
    if (models.empty()) return {};
    const std::vector<std::byte> glb = encode_instances_glb(models, "../../models");
    node.has_content = true;
    found_.bytes += glb.size();
    return folder_.write("objects/" + file_of(entry.id) + ".glb", glb);
  }

  struct Model {
    ModelBuffer buffer;
    float radius_m = 0, bottom_m = 0, top_m = 0;
  };

  Status add_instance(const PlacedObject& object, LonLat at, const Model& model, ModelInstances& out,
                      Volume& volume) {
    const auto ground = sampler_.height_at(at);
    if (!ground) return ground.error();
    const double quantum = pack_.header().quantum_m;
    const double own = *ground ? (*ground)->metres : 0;
    const double foot = static_cast<double>(foot_quanta(object, own, quantum)) * quantum + shift_.at(at);
    const double scale = object.scale_factor();
    const Ellipsoid& shape = pack_.header().body.shape;
    out.instances.push_back({geocentric(at, foot, shape), at, object.heading_degrees(), scale});
    const DegreeLengths degree = degree_lengths(at.lat, shape);
    const double radius = static_cast<double>(model.radius_m) * scale;
    const double east = std::min(radius / std::max(degree.lon_m, 1e-3), 180.0), north = radius / degree.lat_m;
    volume.add({{at.lon - east, at.lat - north, at.lon + east, at.lat + north},
                foot + static_cast<double>(model.bottom_m) * scale,
                foot + static_cast<double>(model.top_m) * scale + radius * radius / shape.semi_minor_m});
    ++found_.objects;
    return {};
  }

  bool is_in_region(LonLat at) const {
    if (!region_) return true;
    const double turns = 360 * std::ceil((region_->west - at.lon) / 360);
    return region_->contains({at.lon + turns, at.lat});
  }

  /// The model, which is written when it is first asked for.
  Result<const Model*> model_of(std::uint16_t number) {
    if (const auto known = models_.find(number); known != models_.end()) return &known->second;
    if (number >= pack_.model_count())
      return bad_data(fmt::format("{}: objects: expected models of the pack, found number {}",
                                  pack_.path().string(), number));
    const auto model = pack_.read_model(number);
    if (!model) return model.error();
    Model& own = models_[number];
    own = {model_buffer(number, *model), model->radius_m, model->bottom_m, model->top_m};
    const std::string name = "objects/models/" + std::to_string(number);
    if (auto status = folder_.write(name + ".bin", own.buffer.bytes); !status) return status.error();
    const TextureTile& texture = model->levels.empty() ? model->billboard : model->texture;
    if (auto status = write_texture_png(folder_.path() / (name + ".png"), texture); !status)
      return status.error();
    found_.bytes += own.buffer.bytes.size();
    return &own;
  }

  TreeJson json_of(const ObjectNode& node, const std::string& up, int left,
                   std::vector<const ObjectNode*>& others) const {
    TreeJson json = {{"boundingVolume", {{"region", node.volume.region()}}},
                     {"geometricError", node.error_m},
                     {"refine", "ADD"}};
    if (left == 0 && !node.children.empty()) {
      others.push_back(&node);
      json["content"] = {{"uri", up + file_of(node.id) + ".json"}};
      return json;
    }
    if (node.has_content) json["content"] = {{"uri", up + file_of(node.id) + ".glb"}};
    for (const ObjectNode& child : node.children)
      json["children"].push_back(json_of(child, up, left - 1, others));
    return json;
  }

  Status write_tree(const ObjectNode& root, const std::string& name, const std::string& up) {
    std::vector<const ObjectNode*> others;
    const TreeJson file = {{"asset", {{"version", "1.1"}, {"generator", "cairn " CAIRN_VERSION}}},
                           {"geometricError", root.error_m},
                           {"root", json_of(root, up, kLevelsOfFile, others)}};
    const std::string text = file.dump(1) + "\n";
    found_.bytes += text.size();
    if (auto status = folder_.write("objects/" + name + ".json", text); !status) return status;
    for (const ObjectNode* other : others) {
      if (auto status = write_tree(*other, file_of(other->id), "../../"); !status) return status;
    }
    return {};
  }

  const PackReader& pack_;
  const std::optional<GeoBounds>& region_;
  const VerticalShift& shift_;
  const ExportFolder& folder_;
  PackSampler sampler_;
  std::map<std::uint16_t, Model> models_;
  ObjectTileset found_;
};

}  // namespace

Result<std::optional<ObjectTileset>> write_object_tileset(const PackReader& pack,
                                                          const std::optional<GeoBounds>& region,
                                                          const VerticalShift& shift,
                                                          const ExportFolder& folder) {
  return ObjectTilesetWriter(pack, region, shift, folder).run();
}

}  // namespace cairn
