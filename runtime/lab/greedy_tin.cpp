#include "runtime/lab/greedy_tin.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "format/delaunay.h"
#include "runtime/lod/mesh/grid_positions.h"
#include "runtime/lod/mesh/screen.h"
#include "runtime/view/horizon.h"
#include "runtime/view/sample_lattice.h"
#include "runtime/view/view_frustum.h"

namespace cairn {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kNearest_m = 1;

struct Sample {
  GridPlace place;
  float u = 0;  ///< pixels from the middle of the viewport
  float v = 0;
  glm::dvec3 at{0};  ///< right, up, and along the view
  float height_m = 0;
};

/// The finest samples in the viewport, on one grid of the finest spacing among them.
class ViewSamples {
 public:
  ViewSamples(LabTerrain& terrain, const ViewState& view)
      : terrain_(terrain),
        view_(view),
        screen_(view),
        volume_(view, Occluder(terrain.lowest_m(), view.ellipsoid)),
        horizon_(screen_.camera().position, Occluder(terrain.lowest_m(), view.ellipsoid)),
        middle_(static_cast<std::int64_t>(std::llround(view.eye.lon + 180)) << kLatticeLevel) {}

  Status collect() {
    for (const FinestArea& area : terrain_.finest()) {
      if (volume_.sees(area.volume)) unit_ = std::min(unit_, spacing_of(area.source.id));
    }
    for (const FinestArea& area : terrain_.finest()) {
      if (!volume_.sees(area.volume)) continue;
      const auto heights = terrain_.heights(area.source);
      if (!heights) return heights.error();
      add(area, **heights);
    }
    return {};
  }

  std::vector<Sample>& samples() { return samples_; }
  LatticePoint point_of(const GridPlace& place) const {
    return canonical({place.column * unit_ + middle_ - kLatticeAround / 2, place.row * unit_});
  }
  /// In the camera; beyond a pole, of the pole.
  glm::dvec3 position_of(const GridPlace& place, double height_m) const {
    LatticePoint point = point_of(place);
    point.y = std::clamp<std::int64_t>(point.y, 0, kLatticePoleToPole);
    return screen_.camera().in_camera(to_geocentric(point, height_m, view_.ellipsoid));
  }

 private:
  std::int64_t spacing_of(const TileId& source) const {
    return lattice_width(source.level) / (terrain_.pack().header().tile_size - 1);
  }

  void add(const FinestArea& area, const HeightTile& heights) {
    const std::int64_t spacing = spacing_of(area.source.id);
    const int cells = (heights.size - 1) >> (area.area.level - area.source.id.level);
    const LatticePoint corner = south_west_of(area.area), origin = south_west_of(area.source.id);
    const auto column = static_cast<int>((corner.x - origin.x) / spacing);
    const auto row = static_cast<int>((corner.y - origin.y) / spacing);
    const GridPositions positions(corner, spacing, cells + 1, view_.ellipsoid);
    for (int r = 0; r <= cells; ++r) {
      for (int c = 0; c <= cells; ++c) {
        if (heights.is_void(column + c, row + r)) continue;
        const double height_m = heights.at(column + c, row + r) * terrain_.pack().header().quantum_m;
        const glm::dvec3 point = positions.at(c, r, height_m);
        if (horizon_.hides(point)) continue;
        add({{across_from_eye(corner.x + c * spacing) / unit_, (corner.y + r * spacing) / unit_},
             0,
             0,
             screen_.camera().in_camera(point),
             static_cast<float>(height_m)});
      }
    }
  }

  void add(Sample sample) {
    if (sample.at.z < kNearest_m) return;
    const double focal = screen_.pixels_per_radian() / sample.at.z;
    const double u = sample.at.x * focal, v = sample.at.y * focal;
    if (std::abs(u) > view_.viewport_width_px / 2.0 || std::abs(v) > view_.viewport_height_px / 2.0) return;
    sample.u = static_cast<float>(u);
    sample.v = static_cast<float>(v);
    samples_.push_back(sample);
  }

  /// East of the line that is half the Earth away from the eye.
  std::int64_t across_from_eye(std::int64_t x) const {
    const std::int64_t offset = (x - middle_ + kLatticeAround + kLatticeAround / 2) % kLatticeAround;
    return offset < 0 ? offset + kLatticeAround : offset;
  }

  LabTerrain& terrain_;
  const ViewState view_;
  const Screen screen_;
  const ViewFrustum volume_;
  const Horizon horizon_;
  const std::int64_t middle_;  ///< at a whole degree, so that it is a multiple of every spacing
  std::int64_t unit_ = std::int64_t{1} << kLatticeLevel;
  std::vector<Sample> samples_;
};

class Insertion {
 public:
  Insertion(ViewSamples& visible, double focal_px)
      : samples_(std::move(visible.samples())), focal_px_(focal_px), net_(south_west(), north_east()) {
    for (const GridPlace& corner : net_.places())
      vertices_.push_back(visible.position_of(corner, static_cast<double>(nearest(corner).height_m)));
    buckets_.resize(2);
    for (std::size_t i = 0; i < samples_.size(); ++i)
      buckets_[net_.covers(0, samples_[i].place) ? 0 : 1].push_back(static_cast<std::uint32_t>(i));
    worst_.resize(2);
    for (const std::size_t t : {0, 1}) measure(t);
  }

  template <class PointOf>
  GreedyTin run(double tolerance_px, std::size_t most_vertices, const PointOf& point_of) {
    while (!queue_.empty() && vertices_.size() < most_vertices) {
      const Entry top = queue_.top();
      if (top.error_px <= tolerance_px) break;
      queue_.pop();
      if (worst_[top.triangle].version == top.version) insert(top.triangle);
    }
    GreedyTin tin = count();
    for (std::size_t i = 0; i < vertices_.size(); ++i)
      tin.net.push_back({point_of(net_.places()[i]), vertices_[i]});
    for (const auto& triangle : net_.triangles()) {
      const auto& v = triangle.vertices;
      tin.faces.push_back({static_cast<std::uint32_t>(v[0]), static_cast<std::uint32_t>(v[1]),
                           static_cast<std::uint32_t>(v[2])});
    }
    return tin;
  }

 private:
  struct Worst {
    double error_px = 0;
    std::uint32_t sample = 0;
    std::uint64_t version = 0;
  };
  struct Entry {
    double error_px;
    std::size_t triangle;
    std::uint64_t version;
    bool operator<(const Entry& other) const { return error_px < other.error_px; }
  };

  // The rectangle is one wider than the samples, so that none lies on its rim.
  GridPlace south_west() const {
    GridPlace low = samples_.front().place;
    for (const Sample& s : samples_)
      low = {std::min(low.column, s.place.column), std::min(low.row, s.place.row)};
    return {low.column - 1, low.row - 1};
  }
  GridPlace north_east() const {
    GridPlace high = samples_.front().place;
    for (const Sample& s : samples_)
      high = {std::max(high.column, s.place.column), std::max(high.row, s.place.row)};
    return {high.column + 1, high.row + 1};
  }
  const Sample& nearest(const GridPlace& corner) const {
    const auto distance = [&](const Sample& s) {
      return std::hypot(static_cast<double>(s.place.column - corner.column),
                        static_cast<double>(s.place.row - corner.row));
    };
    return *std::min_element(samples_.begin(), samples_.end(),
                             [&](const Sample& a, const Sample& b) { return distance(a) < distance(b); });
  }

  void insert(std::size_t triangle) {
    const Sample& sample = samples_[worst_[triangle].sample];
    const std::vector<std::size_t> changed = net_.insert(sample.place, triangle);
    vertices_.push_back(sample.at);
    buckets_.resize(net_.triangles().size());
    worst_.resize(net_.triangles().size());
    std::vector<std::uint32_t> loose;
    for (const std::size_t t : changed) {
      loose.insert(loose.end(), buckets_[t].begin(), buckets_[t].end());
      buckets_[t].clear();
    }
    std::size_t last = changed.front();
    for (const std::uint32_t i : loose) {
      const GridPlace& place = samples_[i].place;
      if (place == sample.place) continue;
      // Samples come along rows: the next is often where the last was.
      if (!net_.covers(last, place))
        last = *std::find_if(changed.begin(), changed.end(),
                             [&](std::size_t t) { return net_.covers(t, place); });
      buckets_[last].push_back(i);
    }
    for (const std::size_t t : changed) measure(t);
  }

  void measure(std::size_t triangle) {
    const auto& v = net_.triangles()[triangle].vertices;
    const GridPlace &a = net_.places()[v[0]], &b = net_.places()[v[1]], &c = net_.places()[v[2]];
    const glm::dvec3 p = vertices_[v[0]], to_b = vertices_[v[1]] - p, to_c = vertices_[v[2]] - p;
    const double scale = 1 / static_cast<double>(doubled_area(a, b, c));
    Worst worst{0, 0, worst_[triangle].version + 1};
    for (const std::uint32_t i : buckets_[triangle]) {
      const Sample& s = samples_[i];
      const double along_b = static_cast<double>(doubled_area(a, s.place, c)) * scale;
      const double along_c = static_cast<double>(doubled_area(a, b, s.place)) * scale;
      const glm::dvec3 at = p + along_b * to_b + along_c * to_c;
      const double f = focal_px_ / at.z;
      const double du = at.x * f - static_cast<double>(s.u), dv = at.y * f - static_cast<double>(s.v);
      const double error = at.z > 0 ? std::sqrt(du * du + dv * dv) : kInfinite;
      if (error > worst.error_px) {
        worst.error_px = error;
        worst.sample = i;
      }
    }
    worst_[triangle] = worst;
    if (worst.error_px > 0) queue_.push({worst.error_px, triangle, worst.version});
  }

  GreedyTin count() const {
    GreedyTin result;
    result.vertices = vertices_.size() - 4;
    result.samples = samples_.size();
    for (std::size_t t = 0; t < net_.triangles().size(); ++t) {
      const auto& v = net_.triangles()[t].vertices;
      const bool touches =
          !buckets_[t].empty() || std::any_of(v.begin(), v.end(), [](std::size_t i) { return i >= 4; });
      result.triangles += touches ? 1 : 0;
      result.max_px = std::max(result.max_px, worst_[t].error_px);
    }
    return result;
  }

  const std::vector<Sample> samples_;
  const double focal_px_;
  Delaunay net_;
  std::vector<glm::dvec3> vertices_;  ///< in the camera
  std::vector<std::vector<std::uint32_t>> buckets_;
  std::vector<Worst> worst_;
  std::priority_queue<Entry> queue_;
};

}  // namespace

Result<GreedyTin> greedy_tin(LabTerrain& terrain, const ViewState& view, double tolerance_px,
                             std::size_t most_vertices) {
  ViewSamples visible(terrain, view);
  if (auto status = visible.collect(); !status) return status.error();
  if (visible.samples().empty()) return GreedyTin{};
  return Insertion(visible, Screen(view).pixels_per_radian())
      .run(tolerance_px, most_vertices, [&](const GridPlace& place) { return visible.point_of(place); });
}

}  // namespace cairn
