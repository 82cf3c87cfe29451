#include "builder/export/mesh_error.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "builder/export/grid_index.h"

namespace cairn {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kSlack = 1e-9;  // of a step: a sample on an edge is found on one side of it at least

class Meter {
 public:
  Meter(const DecodedMesh& mesh, std::span<const HeightSamples> grids, std::int64_t side, double limit_m)
      : mesh_(mesh), grids_(grids), index_(grids, side), limit_m_(limit_m) {}

  MeshError run() {
    for (const auto& triangle : mesh_.triangles) {
      const auto [a, b, c] = triangle;
      const auto [west, east] = std::minmax({mesh_.columns[a], mesh_.columns[b], mesh_.columns[c]});
      const auto [south, north] = std::minmax({mesh_.rows[a], mesh_.rows[b], mesh_.rows[c]});
      for (const std::uint32_t g : index_.over(west, south, east, north)) {
        grid_ = g;
        measure_samples(triangle);
        for (std::size_t i = 0; i < 3; ++i) {
          const std::uint32_t from = triangle[i], to = triangle[(i + 1) % 3];
          // An inner edge has a triangle on each side; one on the border runs along samples.
          if (from < to) measure_edge(from, to);
        }
      }
    }
    return worst_;
  }

 private:
  const HeightSamples& grid() const { return grids_[grid_]; }

  /// NaN where the sample does not count.
  double sample(std::int64_t c, std::int64_t r) const {
    const std::size_t i = grid().index(static_cast<int>(c), static_cast<int>(r));
    if (!grid().voids.empty() && grid().voids[i] != 0) return kNan;
    return static_cast<double>(grid().metres[i]);
  }
  double to_column(double column) const {
    return (column - static_cast<double>(grid().column)) / static_cast<double>(grid().step);
  }
  double to_row(double row) const {
    return (row - static_cast<double>(grid().row)) / static_cast<double>(grid().step);
  }

  void note(double error, double c, double r) {
    const double metres = error + grid().error_m;
    if (!(metres > std::min(worst_.metres, limit_m_))) return;
    worst_.metres = std::max(worst_.metres, metres);
    if (metres <= limit_m_) return;
    worst_.above.push_back({grid_, static_cast<double>(grid().column) + c * static_cast<double>(grid().step),
                            static_cast<double>(grid().row) + r * static_cast<double>(grid().step)});
  }

  void measure_samples(const std::array<std::uint32_t, 3>& triangle) {
    std::array<double, 3> x, y, z;
    for (std::size_t i = 0; i < 3; ++i) {
      x[i] = to_column(mesh_.columns[triangle[i]]);
      y[i] = to_row(mesh_.rows[triangle[i]]);
      z[i] = mesh_.metres[triangle[i]];
    }
    const double area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
    if (!(area > 0)) return;
    const double east = ((z[1] - z[0]) * (y[2] - y[0]) - (z[2] - z[0]) * (y[1] - y[0])) / area;
    const double north = ((z[2] - z[0]) * (x[1] - x[0]) - (z[1] - z[0]) * (x[2] - x[0])) / area;
    const auto [south_y, north_y] = std::minmax({y[0], y[1], y[2]});
    const auto first = static_cast<std::int64_t>(std::ceil(std::max(south_y - kSlack, 0.0)));
    const auto last = static_cast<std::int64_t>(
        std::floor(std::min(north_y + kSlack, static_cast<double>(grid().rows - 1))));
    for (std::int64_t r = first; r <= last; ++r) {
      const auto row = static_cast<double>(r);
      double west_x = std::numeric_limits<double>::infinity(), east_x = -west_x;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3;
        if (row < std::min(y[i], y[j]) - kSlack || row > std::max(y[i], y[j]) + kSlack) continue;
        const double t = y[i] == y[j] ? 0 : std::clamp((row - y[i]) / (y[j] - y[i]), 0.0, 1.0);
        const double at = x[i] + t * (x[j] - x[i]);
        west_x = std::min({west_x, at, y[i] == y[j] ? x[j] : at});
        east_x = std::max({east_x, at, y[i] == y[j] ? x[j] : at});
      }
      if (!(east_x >= west_x)) continue;
      const auto begin = static_cast<std::int64_t>(std::ceil(std::max(west_x - kSlack, 0.0)));
      const auto end = static_cast<std::int64_t>(
          std::floor(std::min(east_x + kSlack, static_cast<double>(grid().columns - 1))));
      for (std::int64_t c = begin; c <= end; ++c) {
        const double at = z[0] + east * (static_cast<double>(c) - x[0]) + north * (row - y[0]);
        note(std::abs(sample(c, r) - at), static_cast<double>(c), row);
      }
    }
  }

  // Along an edge, piece by piece between the grid's lines: in a cell the difference is a parabola.
  void measure_edge(std::uint32_t a, std::uint32_t b) {
    const double x0 = to_column(mesh_.columns[a]), x1 = to_column(mesh_.columns[b]);
    const double y0 = to_row(mesh_.rows[a]), y1 = to_row(mesh_.rows[b]);
    double from = 0, to = 1;
    if (!clip(x0, x1, grid().columns - 1, from, to) || !clip(y0, y1, grid().rows - 1, from, to)) return;
    double t = from;
    while (t < to) {
      const double next = std::min({to, next_line(x0, x1, t), next_line(y0, y1, t)});
      measure_piece(a, b, {x0, y0, x1, y1}, t, next);
      t = next;
    }
  }

  static bool clip(double p, double q, int last, double& from, double& to) {
    if (p == q) return p >= 0 && p <= last;
    double enter = (0 - p) / (q - p), leave = (last - p) / (q - p);
    if (enter > leave) std::swap(enter, leave);
    from = std::max(from, enter);
    to = std::min(to, leave);
    return from < to;
  }

  /// Where the edge next meets a line of the grid after t.
  static double next_line(double p, double q, double t) {
    if (p == q) return std::numeric_limits<double>::infinity();
    const double at = p + t * (q - p);
    const double line = q > p ? std::floor(at + kSlack) + 1 : std::ceil(at - kSlack) - 1;
    return (line - p) / (q - p);
  }

  struct Edge {
    double x0, y0, x1, y1;
  };
  void measure_piece(std::uint32_t a, std::uint32_t b, const Edge& e, double t0, double t1) {
    const double tm = (t0 + t1) / 2;
    const auto cell = [](double at, int last) {
      return std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(at)), 0, last - 1);
    };
    const std::int64_t c = cell(e.x0 + tm * (e.x1 - e.x0), grid().columns - 1);
    const std::int64_t r = cell(e.y0 + tm * (e.y1 - e.y0), grid().rows - 1);
    const double sw = sample(c, r), se = sample(c + 1, r), nw = sample(c, r + 1), ne = sample(c + 1, r + 1);
    if (std::isnan(sw + se + nw + ne)) return;
    const auto off = [&](double t) {
      const double u = e.x0 + t * (e.x1 - e.x0) - static_cast<double>(c);
      const double v = e.y0 + t * (e.y1 - e.y0) - static_cast<double>(r);
      const double ground = (sw * (1 - u) + se * u) * (1 - v) + (nw * (1 - u) + ne * u) * v;
      return mesh_.metres[a] + t * (mesh_.metres[b] - mesh_.metres[a]) - ground;
    };
    const auto look = [&](double t) {
      note(std::abs(off(t)), e.x0 + t * (e.x1 - e.x0), e.y0 + t * (e.y1 - e.y0));
    };
    const double f0 = off(t0), fm = off(tm), f1 = off(t1);
    look(t0);
    look(t1);
    const double bend = f0 - 2 * fm + f1;  // f = f0 + (4fm - 3f0 - f1)·s + 2·bend·s², s from 0 to 1
    if (bend == 0) return;
    const double s = (3 * f0 + f1 - 4 * fm) / (4 * bend);
    if (s > 0 && s < 1) look(t0 + s * (t1 - t0));
  }

  const DecodedMesh& mesh_;
  std::span<const HeightSamples> grids_;
  GridIndex index_;
  double limit_m_;
  std::size_t grid_ = 0;
  MeshError worst_;
};

}  // namespace

MeshError measure_mesh(const DecodedMesh& mesh, std::span<const HeightSamples> grids, std::int64_t side,
                       double limit_m) {
  return Meter(mesh, grids, side, limit_m).run();
}

}  // namespace cairn
