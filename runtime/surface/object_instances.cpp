#include "runtime/surface/object_instances.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

#include "runtime/view/screen_scale.h"

namespace cairn {
namespace {

constexpr std::size_t kFewInstances = 4096;  // room for so many at first
constexpr float kArrival_s = 0.5F;
constexpr float kFadeRatio = 1.5F;        // from nothing to all of an object
constexpr float kBillboardRatio = 1.25F;  // from all of the billboard to none
// Seen from above the side of a model is no picture of it.
constexpr float kSteepest = 0.7F;  // sine of the eye's elevation

/// A model of a frame, and where its draws begin.
struct ModelUse {
  std::shared_ptr<const ObjectModel> model;
  std::uint32_t first_draw = 0;  // of its levels and, last, its billboard
  float billboard_px = 0;        // the height that a view of the billboard has in texels
};

/// An instance and the draw that it belongs to.
struct ChosenInstance {
  ObjectInstance instance;
  std::uint32_t draw = 0;
};

class Chooser {
 public:
  Chooser(const ObjectArrivals& arrivals, const ObjectRules& rules)
      : arrivals_(arrivals),
        camera_(camera_frame(rules.view)),
        pixels_per_radian_(static_cast<float>(pixels_per_radian(rules.view))),
        smallest_px_(static_cast<float>(rules.smallest_px)),
        farthest_per_m_(pixels_per_radian_ / smallest_px_),
        error_px_(static_cast<float>(rules.error_px)) {
    chosen_.reserve(kFewInstances);
    const std::array<glm::dvec3, 5> normals = inward_normals(camera_, rules.view);
    for (std::size_t i = 0; i < normals.size(); ++i) inward_[i] = glm::vec3(normals[i]);
  }

  void add(const ObjectPatch& patch) {
    const float share = arrivals_.share_of(*patch.objects);
    if (share <= 0 || !may_be_seen(patch.cluster)) return;
    const bool is_inside = is_in_picture(patch.cluster);
    std::vector<std::size_t>& uses = uses_of(*patch.objects);
    for (std::size_t i = 0; i < patch.feet.size(); ++i) {
      const StandingObject& object = patch.standing[i];
      const ObjectFoot& foot = patch.feet[i];
      const glm::vec3 from_eye =
          glm::vec3(foot.place - camera_.position) + foot.to_coarser * patch.coarser_share;
      // Most of the objects in memory are too small where they are: that is the cheapest test.
      const float farthest = object.size_m * farthest_per_m_;
      if (glm::dot(from_eye, from_eye) >= farthest * farthest) continue;
      if (!is_inside && !in_picture(from_eye, object.reach_m())) continue;
      const float distance = glm::length(from_eye);
      const float px_per_m = pixels_per_radian_ / std::max(distance, 1e-3F);
      const float size_px = object.size_m * px_per_m;
      if (size_px <= smallest_px_) continue;
      const float fade = share * std::min((size_px / smallest_px_ - 1) / (kFadeRatio - 1), 1.0F);
      const float scale = static_cast<float>(object.placed.scale) / 4096;
      const ObjectInstance instance{from_eye, scale, foot.heading, {0, fade}};
      const float elevation = -glm::dot(from_eye, up_of(foot.place)) / std::max(distance, 1e-3F);
      choose(all_[uses[object.slot]], instance, size_px, px_per_m * scale, elevation);
    }
  }

  /// Puts the instances of each draw together, in the order in which they came.
  SurfaceObjects take() {
    SurfaceObjects out;
    out.objects = objects_;
    out.billboards = billboards_;
    std::vector<std::uint32_t> next(counts_.size());
    std::uint32_t first = 0;
    for (const ModelUse& use : all_) {
      const std::size_t levels = use.model->levels.size();
      for (std::size_t level = 0; level <= levels; ++level) {
        const std::uint32_t count = counts_[use.first_draw + level];
        next[use.first_draw + level] = first;
        if (count == 0) continue;
        const bool is_billboard = level == levels;
        out.draws.push_back(
            {use.model, is_billboard ? ObjectDraw::kBillboard : static_cast<int>(level), first, count});
        out.triangles += std::uint64_t{count} * (is_billboard ? 2 : use.model->levels[level].count / 3);
        first += count;
      }
    }
    out.instances.resize(chosen_.size());
    for (const ChosenInstance& each : chosen_) out.instances[next[each.draw]++] = each.instance;
    return out;
  }

 private:
  bool may_be_seen(const ObjectCluster& cluster) const {
    const auto from_eye = glm::vec3(cluster.middle - camera_.position);
    const float farthest = cluster.largest_m * farthest_per_m_ + cluster.radius_m;
    if (glm::dot(from_eye, from_eye) >= farthest * farthest) return false;
    return in_picture(from_eye, cluster.radius_m + static_cast<float>(kReachPerSize) * cluster.largest_m);
  }

  /// Whether all feet are: then no object has to be looked at.
  bool is_in_picture(const ObjectCluster& cluster) const {
    return in_picture(glm::vec3(cluster.middle - camera_.position), -cluster.radius_m);
  }

  bool in_picture(const glm::vec3& from_eye, float reach_m) const {
    return std::all_of(inward_.begin(), inward_.end(),
                       [&](const glm::vec3& normal) { return glm::dot(from_eye, normal) >= -reach_m; });
  }

  static glm::vec3 up_of(const glm::dvec3& place) { return glm::normalize(glm::vec3(place)); }

  std::vector<std::size_t>& uses_of(const LoadedObjects& tile) {
    std::vector<std::size_t>& uses = tile_uses_[&tile];
    if (!uses.empty()) return uses;
    for (const auto& model : tile.models()) {
      const auto [known, fresh] = numbers_.try_emplace(model.get(), all_.size());
      if (fresh) add_model(model);
      uses.push_back(known->second);
    }
    return uses;
  }

  void add_model(const std::shared_ptr<const ObjectModel>& model) {
    const int rows = model->billboard_views == kBillboardViews ? 2 : 1;
    all_.push_back({model, static_cast<std::uint32_t>(counts_.size()),
                    static_cast<float>(model->billboard.size) / static_cast<float>(rows)});
    counts_.resize(counts_.size() + model->levels.size() + 1);
  }

  void draw(const ModelUse& use, std::size_t level, const ObjectInstance& instance) {
    const auto number = use.first_draw + static_cast<std::uint32_t>(level);
    ++counts_[number];
    chosen_.push_back({instance, number});
  }

  void choose(const ModelUse& use, ObjectInstance instance, float size_px, float px_per_model_m,
              float elevation) {
    ++objects_;
    const auto& levels = use.model->levels;
    // How much of it is the billboard.
    float far = levels.empty() ? 1 : 0;
    if (!levels.empty() && elevation < kSteepest) {
      const float above = size_px / use.billboard_px - 1;
      far = std::clamp(1 - above / (kBillboardRatio - 1), 0.0F, 1.0F);
    }
    billboards_ += far > 0;
    const float all = instance.shown.y;
    if (far > 0) {
      ObjectInstance billboard = instance;
      billboard.shown.x = all * (1 - far);
      draw(use, levels.size(), billboard);
    }
    if (far >= 1) return;
    instance.shown.y = all * (1 - far);
    std::size_t level = levels.size() - 1;
    while (level > 0 && levels[level].error_m * px_per_model_m > error_px_) --level;
    draw(use, level, instance);
  }

  const ObjectArrivals& arrivals_;
  CameraFrame camera_;
  std::array<glm::vec3, 5> inward_{};
  float pixels_per_radian_;
  float smallest_px_;
  float farthest_per_m_;  // where an object of 1 m has the smallest size
  float error_px_;
  std::vector<ModelUse> all_;
  std::vector<std::uint32_t> counts_;  // by draw
  std::vector<ChosenInstance> chosen_;
  std::unordered_map<const ObjectModel*, std::size_t> numbers_;
  std::unordered_map<const LoadedObjects*, std::vector<std::size_t>> tile_uses_;
  std::size_t objects_ = 0;
  std::size_t billboards_ = 0;
};

}  // namespace

void ObjectArrivals::update(std::span<const std::shared_ptr<const LoadedObjects>> tiles, double frame_s) {
  const bool is_first = shares_.empty();
  std::unordered_map<const LoadedObjects*, float> now;
  for (const std::shared_ptr<const LoadedObjects>& tile : tiles) {
    const auto known = shares_.find(tile.get());
    const float before = known != shares_.end() ? known->second : 0;
    now[tile.get()] = is_first ? 1 : std::min(before + static_cast<float>(frame_s) / kArrival_s, 1.0F);
  }
  shares_ = std::move(now);
}

float ObjectArrivals::share_of(const LoadedObjects& tile) const {
  const auto known = shares_.find(&tile);
  return known == shares_.end() ? 1 : known->second;
}

SurfaceObjects object_instances(std::span<const ObjectPatch> patches, const ObjectArrivals& arrivals,
                                const ObjectRules& rules) {
  Chooser chooser(arrivals, rules);
  for (const ObjectPatch& patch : patches) chooser.add(patch);
  return chooser.take();
}

}  // namespace cairn
