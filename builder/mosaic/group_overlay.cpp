#include "builder/mosaic/group_overlay.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "builder/mosaic/fade_weight.h"
#include "builder/mosaic/fit_borders.h"
#include "builder/mosaic/upsample.h"

namespace cairn {
namespace {

constexpr double kOnRim = 1e-10;       // degrees (10 µm): a place so near to a footprint lies in it
constexpr double kFadeEnd = 1 - 1e-6;  // of a fade: a post that lies one whole fade away is beyond it

SampleWindow grown(SampleWindow w, int by) {
  w.column -= by;
  w.row -= by;
  w.columns += 2 * by;
  w.rows += 2 * by;
  return w;
}

GeoBounds bounds_of(const SampleWindow& w) {
  return {w.lon_of(0), w.lat_of(0), w.lon_of(w.columns - 1), w.lat_of(w.rows - 1)};
}

bool all_sourced(const std::vector<SampleState>& states) {
  return std::all_of(states.begin(), states.end(), [](SampleState s) { return s == SampleState::sourced; });
}

double distance(LonLat a, LonLat b) {
  return std::max(std::abs(a.lon - b.lon), std::abs(a.lat - b.lat));
}

// Whether the group may have posts all over the rectangle; its states then say whether it has.
bool covers_corners(const SourceGroup& group, const GeoBounds& b) {
  const double beside = group.spacing_degrees();
  const Footprint near = group.footprint().near(b, beside);
  for (const LonLat corner :
       {LonLat{b.west, b.south}, {b.east, b.south}, {b.west, b.north}, {b.east, b.north}})
    if (!(near.distance_to(corner) <= beside)) return false;
  return true;
}

void lose_all(MeasuredPosts& posts) {
  std::fill(posts.heights.begin(), posts.heights.end(), std::numeric_limits<float>::quiet_NaN());
  posts.lost.insert(posts.lost.end(), posts.placed.begin(), posts.placed.end());
  posts.placed.clear();
}

// A place among the samples of a window, and the weights of the four around it.
struct Bilinear {
  std::size_t south_west = 0;
  double east = 0;
  double north = 0;

  double weight(int c, int r) const { return (c == 0 ? 1 - east : east) * (r == 0 ? 1 - north : north); }
};

constexpr double kSnap = 1e-6;  // sample spacings: a place so near to a sample lies on it

Bilinear bilinear_at(double x, double y, const SampleWindow& window) {
  const auto split = [](double at, int count, double& fraction) {
    const double whole = std::clamp(std::floor(at + kSnap), 0.0, static_cast<double>(std::max(count - 2, 0)));
    fraction = at - whole;
    if (fraction < kSnap) fraction = 0;
    if (fraction > 1 - kSnap) fraction = 1;
    return static_cast<std::size_t>(whole);
  };
  Bilinear b;
  const std::size_t c = split(x, window.columns, b.east);
  b.south_west = split(y, window.rows, b.north) * static_cast<std::size_t>(window.columns) + c;
  return b;
}

template <class Visit>
void for_each_corner(const Bilinear& b, const SampleWindow& window, const Visit& visit) {
  for (const int r : {0, 1})
    for (const int c : {0, 1})
      if (const double w = b.weight(c, r); w > 0)
        visit(b.south_west + static_cast<std::size_t>(r * window.columns + c), w);
}

}  // namespace

// How the upper group ends in a window.
struct GroupOverlay::Rim {
  enum class Kind : std::uint8_t {
    beneath,  ///< what lies beneath shows unchanged
    own,      ///< the group alone
    fading,   ///< a mixture of both
    gap,      ///< between two groups that touch
  };
  std::vector<Kind> kinds;         // by sample
  std::vector<float> weights;      // of the group's height (gap, own) or of its difference (fading)
  std::vector<float> differences;  // by sample; carried from the rim
  struct Fading {
    std::size_t sample = 0;
    LonLat rim;
    double distance = 0;  // degrees
  };
  std::vector<Fading> fading;  // whose differences are not known yet
  NearestPlace nearest;
};

double GroupOverlay::Layer::reach() const {
  return std::max(fade_degrees, group->spacing_degrees()) + (kFitReach + 2) / samples_per_degree;
}

double GroupOverlay::Layer::margin() const {
  return reach() + (kFitBlock + kFitReach) / samples_per_degree;
}

std::vector<std::size_t> GroupOverlay::reaching(const GeoBounds& bounds) const {
  std::vector<std::size_t> found;
  for (std::size_t k = 0; k < layers_.size(); ++k)
    if (layers_[k].group->comes_within(bounds, layers_[k].reach())) found.push_back(k);
  return found;
}

std::vector<std::size_t> GroupOverlay::needed(const GeoBounds& bounds, int level, std::size_t first) const {
  std::vector<std::size_t> found;
  for (std::size_t k = first; k < layers_.size(); ++k)
    if (layers_[k].level <= level && layers_[k].group->comes_within(bounds, layers_[k].margin()))
      found.push_back(k);
  return found;
}

Result<GroupSamples> GroupOverlay::own_samples(std::size_t layer, const SampleWindow& window,
                                               int level) const {
  const SourceGroup& group = *layers_[layer].group;
  const int levels = level - group.native_level();
  assert(levels >= 0);
  auto samples = group.sample(coarser_window(window, levels));
  if (samples && levels > 0) *samples = upsample(*samples, window, levels);
  if (samples && samples->states.empty()) samples->states.assign(window.count(), SampleState::sourced);
  return samples;
}

Result<OverlaidSamples> GroupOverlay::sample_alone(std::size_t layer, const SampleWindow& window,
                                                   int level) const {
  auto samples = own_samples(layer, window, level);
  if (!samples) return samples.error();
  OverlaidSamples alone;
  alone.heights = std::move(samples->heights);
  alone.states = std::move(samples->states);
  alone.posts.push_back(std::move(samples->posts));
  alone.touched.assign(window.count(), 1);
  return alone;
}

// The posts of layers that another one covers all over the window: they have all lost.
Result<std::vector<MeasuredPosts>> GroupOverlay::covered_posts(std::span<const std::size_t> layers,
                                                               const SampleWindow& window, int level) const {
  std::vector<MeasuredPosts> all;
  for (const std::size_t k : layers) {
    const int levels = level - layers_[k].group->native_level();
    const SampleWindow coarse = coarser_window(window, levels);
    auto posts = layers_[k].group->posts(coarse);
    if (!posts) return posts.error();
    all.push_back(levels > 0 ? posts_in(*posts, coarse, window, levels) : std::move(*posts));
    lose_all(all.back());
  }
  return all;
}

Result<OverlaidSamples> GroupOverlay::sample(std::span<const std::size_t> layers, const SampleWindow& window,
                                             int level) const {
  assert(!layers.empty());
  if (layers.size() == 1) return sample_alone(layers.front(), window, level);
  const int levels = level - layers_[layers.front()].level;
  assert(levels >= 0);
  if (levels == 0) return overlay(layers, window, level);

  const SampleWindow coarse = coarser_window(window, levels);
  const auto own_level = overlay(layers, coarse, level - levels);
  if (!own_level) return own_level;
  const auto is_touched = [](std::uint8_t t) { return t != 0; };
  OverlaidSamples fine = upsample(*own_level, coarse, window, levels);
  if (std::all_of(fine.touched.begin(), fine.touched.end(), is_touched)) return fine;
  // Elsewhere it is as if the first group were not there.
  const auto beneath = sample(layers.subspan(1), window, level);
  if (!beneath) return beneath;
  for (std::size_t i = 0; i < fine.touched.size(); ++i) {
    if (is_touched(fine.touched[i])) continue;
    fine.heights[i] = beneath->heights[i];
    fine.states[i] = beneath->states[i];
  }
  return fine;
}

// On the samples of the first layer's own level.
Result<OverlaidSamples> GroupOverlay::overlay(std::span<const std::size_t> layers, const SampleWindow& window,
                                              int level) const {
  const SourceGroup& group = *layers_[layers.front()].group;
  const auto rest = layers.subspan(1);
  // A line lies between two samples, of which the nearer is within the fit's reach.
  const SampleWindow near = grown(window, kFitReach + 1);
  if (covers_corners(group, bounds_of(near))) {
    const auto alone = sample_alone(layers.front(), near, level);
    if (!alone) return alone;
    if (all_sourced(alone->states)) {
      OverlaidSamples part = cut(*alone, near, window);
      auto covered = covered_posts(rest, window, level);
      if (!covered) return covered.error();
      for (MeasuredPosts& posts : *covered) part.posts.push_back(std::move(posts));
      return part;
    }
  }
  // Whole blocks of the fit, and what it looks at around them.
  const SampleWindow wide = fit_window(window);
  auto own = own_samples(layers.front(), wide, level);
  if (!own) return own.error();
  auto overlaid = sample(rest, wide, level);
  if (!overlaid) return overlaid;
  const auto rim = rim_of(layers, wide, level, *own, *overlaid);
  if (!rim) return rim.error();
  lay(*own, *rim, *overlaid);
  drop_losing_posts(layers, wide, *rim, *overlaid);
  overlaid->posts.insert(overlaid->posts.begin(), std::move(own->posts));
  std::vector<double> intervals;
  for (const std::size_t k : layers) intervals.push_back(layers_[k].group->tolerance().interval_m);
  fit_borders(wide, *overlaid, tolerance_m_, intervals);
  return cut(*overlaid, wide, window);
}

// Which samples are whose, and by how much.
Result<GroupOverlay::Rim> GroupOverlay::rim_of(std::span<const std::size_t> layers,
                                               const SampleWindow& window, int level, const GroupSamples& own,
                                               const OverlaidSamples& below) const {
  const Layer& layer = layers_[layers.front()];
  const double reach = std::max(layer.fade_degrees, layer.group->spacing_degrees());
  Rim rim;
  rim.kinds.assign(window.count(), Rim::Kind::beneath);
  rim.weights.assign(window.count(), 0);
  rim.differences.assign(window.count(), 0);
  rim.nearest = layer.group->nearest_within(bounds_of(window), reach);
  const Footprint near = layer.group->footprint().near(bounds_of(window), reach);
  std::size_t at = 0;
  for (int r = 0; r < window.rows; ++r) {
    for (int c = 0; c < window.columns; ++c, ++at) {
      const LonLat place{window.lon_of(c), window.lat_of(r)};
      const SampleState above = own.states[at];
      if (above == SampleState::none && near.distance_to(place) > reach) continue;
      const LonLat rim_place = rim.nearest(place);
      const double beyond = distance(place, rim_place);
      if (below.states[at] == SampleState::none || beyond <= kOnRim) {
        if (above == SampleState::none) continue;
        const bool fades = above == SampleState::filled && !own.fill_weights.empty() &&
                           below.states[at] != SampleState::none;
        rim.weights[at] = fades ? own.fill_weights[at] : 1;
        rim.kinds[at] = rim.weights[at] == 1  ? Rim::Kind::own
                        : rim.weights[at] > 0 ? Rim::Kind::fading
                                              : Rim::Kind::beneath;
        if (rim.kinds[at] == Rim::Kind::fading) rim.differences[at] = own.heights[at] - below.heights[at];
        continue;
      }
      rim.fading.push_back({at, rim_place, beyond});
    }
  }
  if (auto added = add_differences(layers, window, level, rim); !added) return added.error();
  // Between two groups that touch, each counts the more the nearer its rim is.
  std::vector<NearestPlace> rest;
  for (const std::size_t k : layers.subspan(1))
    rest.push_back(layers_[k].group->nearest_within(bounds_of(window), layers_[k].group->spacing_degrees()));
  for (const Rim::Fading& f : rim.fading) {
    const SampleState above = own.states[f.sample];
    if (rim.kinds[f.sample] != Rim::Kind::gap || above != SampleState::sourced) {
      if (rim.kinds[f.sample] == Rim::Kind::gap) rim.kinds[f.sample] = Rim::Kind::beneath;
      continue;
    }
    if (below.states[f.sample] != SampleState::sourced) {
      rim.kinds[f.sample] = Rim::Kind::own;
      rim.weights[f.sample] = 1;
      continue;
    }
    const auto c = static_cast<int>(f.sample % static_cast<std::size_t>(window.columns));
    const auto r = static_cast<int>(f.sample / static_cast<std::size_t>(window.columns));
    const LonLat place{window.lon_of(c), window.lat_of(r)};
    double other = std::numeric_limits<double>::infinity();
    for (const NearestPlace& nearest : rest) other = std::min(other, distance(place, nearest(place)));
    rim.weights[f.sample] = static_cast<float>(std::isfinite(other) ? other / (other + f.distance) : 1);
    if (rim.weights[f.sample] == 0) rim.kinds[f.sample] = Rim::Kind::beneath;
  }
  return rim;
}

// Works out the differences at the rim, for each sample that fades: fading where something lies beneath the
// rim, gap where nothing does. Places on the rim lie together, so they are taken by parts of the rim.
Status GroupOverlay::add_differences(std::span<const std::size_t> layers, const SampleWindow& window,
                                     int level, Rim& rim) const {
  constexpr std::int64_t kPart = 64;  // samples along a side
  const Layer& layer = layers_[layers.front()];
  std::map<std::pair<std::int64_t, std::int64_t>, std::vector<std::size_t>> parts;
  const auto x_of = [&](LonLat p) { return (p.lon + 180.0) * window.samples_per_degree; };
  const auto y_of = [&](LonLat p) { return (p.lat + 90.0) * window.samples_per_degree; };
  const auto whole = [](double at) { return static_cast<std::int64_t>(std::floor(at + kSnap)); };
  for (std::size_t i = 0; i < rim.fading.size(); ++i) {
    const Rim::Fading& f = rim.fading[i];
    const auto part = [&](double at) {
      return whole(at) >= 0 ? whole(at) / kPart : -1 - (-1 - whole(at)) / kPart;
    };
    parts[{part(y_of(f.rim)), part(x_of(f.rim))}].push_back(i);
  }
  for (const auto& [ignored, members] : parts) {
    SampleWindow around = window;
    std::int64_t east = std::numeric_limits<std::int64_t>::min(), north = east;
    around.column = around.row = std::numeric_limits<std::int64_t>::max();
    for (const std::size_t i : members) {
      const LonLat p = rim.fading[i].rim;
      around.column = std::min(around.column, whole(x_of(p)));
      around.row = std::min(around.row, whole(y_of(p)));
      east = std::max(east, whole(x_of(p)) + 1);
      north = std::max(north, whole(y_of(p)) + 1);
    }
    around.columns = static_cast<int>(east - around.column + 1);
    around.rows = static_cast<int>(north - around.row + 1);
    const auto beneath = needed(bounds_of(around), level, layers.front() + 1);
    std::vector<NearestPlace> areas;
    for (const std::size_t k : beneath)
      areas.push_back(
          layers_[k].group->nearest_within(bounds_of(around), layers_[k].group->spacing_degrees()));
    const auto lies_beneath = [&](LonLat p) {
      return std::any_of(areas.begin(), areas.end(),
                         [&](const NearestPlace& nearest) { return distance(p, nearest(p)) <= kOnRim; });
    };
    Result<GroupSamples> own = GroupSamples{};
    Result<OverlaidSamples> below = OverlaidSamples{};
    for (const std::size_t i : members) {
      const Rim::Fading& f = rim.fading[i];
      rim.kinds[f.sample] = Rim::Kind::gap;
      if (!lies_beneath(f.rim)) continue;
      if (f.distance >= kFadeEnd * layer.fade_degrees) {
        rim.kinds[f.sample] = Rim::Kind::beneath;
        continue;
      }
      if (own->heights.empty()) {
        own = own_samples(layers.front(), around, level);
        if (!own) return own.error();
        below = sample(beneath, around, level);
        if (!below) return below.error();
      }
      const auto corner = bilinear_at(x_of(f.rim) - static_cast<double>(around.column),
                                      y_of(f.rim) - static_cast<double>(around.row), around);
      double difference = 0;
      bool known = true;
      for_each_corner(corner, around, [&](std::size_t at, double w) {
        const bool above = own->states[at] != SampleState::none;
        known = known && above && below->states[at] != SampleState::none;
        if (known)
          difference += w * (static_cast<double>(own->heights[at]) - static_cast<double>(below->heights[at]));
      });
      if (!known) continue;
      rim.kinds[f.sample] = Rim::Kind::fading;
      rim.weights[f.sample] = static_cast<float>(fade_weight(f.distance, layer.fade_degrees));
      rim.differences[f.sample] = static_cast<float>(difference);
    }
  }
  return {};
}

// Lays the group over what lies beneath.
void GroupOverlay::lay(const GroupSamples& own, const Rim& rim, OverlaidSamples& below) {
  using Kind = Rim::Kind;
  for (std::size_t at = 0; at < rim.kinds.size(); ++at) {
    const auto w = static_cast<double>(rim.weights[at]);
    float& height = below.heights[at];
    below.touched[at] = static_cast<std::uint8_t>(rim.kinds[at]);
    switch (rim.kinds[at]) {
      case Kind::beneath:
        break;
      case Kind::own:
        height = own.heights[at];
        // A filled void hides nothing that has a value.
        below.states[at] = std::max(own.states[at], below.states[at]);
        break;
      case Kind::fading:
        height =
            static_cast<float>(static_cast<double>(height) + w * static_cast<double>(rim.differences[at]));
        break;
      case Kind::gap:
        height = static_cast<float>(w * static_cast<double>(own.heights[at]) +
                                    (1 - w) * static_cast<double>(height));
        break;
    }
  }
}

// A post beneath loses where the group above has a value, where that one's difference fades, and where it
// lies so near to the group's posts that no surface passes through both.
void GroupOverlay::drop_losing_posts(std::span<const std::size_t> layers, const SampleWindow& window,
                                     const Rim& rim, OverlaidSamples& overlaid) const {
  const double fade = layers_[layers.front()].fade_degrees;
  const double too_near = 0.999 / window.samples_per_degree;
  const auto loses = [&](double x, double y) {
    const Bilinear b = bilinear_at(x, y, window);
    bool any = false, all_own = true, any_own = false, fades = false;
    for_each_corner(b, window, [&](std::size_t at, double) {
      const Rim::Kind kind = rim.kinds[at];
      any = any || kind != Rim::Kind::beneath;
      any_own = any_own || kind == Rim::Kind::own;
      all_own = all_own && kind == Rim::Kind::own;
      fades = fades || kind == Rim::Kind::fading;
    });
    if (!any) return false;
    const LonLat place{(static_cast<double>(window.column) + x) / window.samples_per_degree - 180.0,
                       (static_cast<double>(window.row) + y) / window.samples_per_degree - 90.0};
    const double beyond = all_own ? 0 : distance(place, rim.nearest(place));
    if (beyond <= kOnRim) return any_own || fades;
    return beyond < too_near || (fades && beyond < kFadeEnd * fade);
  };
  for (MeasuredPosts& posts : overlaid.posts) {
    for (std::size_t r = 0; r < posts.ys.size(); ++r)
      for (std::size_t c = 0; c < posts.xs.size(); ++c) {
        float& height = posts.heights[r * posts.xs.size() + c];
        if (!std::isnan(height) && loses(posts.xs[c], posts.ys[r]))
          height = std::numeric_limits<float>::quiet_NaN();
      }
    const auto lost = std::stable_partition(posts.placed.begin(), posts.placed.end(),
                                            [&](const MeasuredPosts::Placed& p) { return !loses(p.x, p.y); });
    posts.lost.insert(posts.lost.end(), lost, posts.placed.end());
    posts.placed.erase(lost, posts.placed.end());
  }
}

}  // namespace cairn
