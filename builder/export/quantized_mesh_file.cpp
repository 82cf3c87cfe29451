#include "builder/export/quantized_mesh_file.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <string>

#include <nlohmann/json.hpp>

#include "format/tile_number.h"

namespace cairn {
namespace {

constexpr std::uint8_t kNormalsExtension = 1;
constexpr std::uint8_t kMetadataExtension = 4;
constexpr std::size_t kMost16BitVertices = 65536;

template <class T>
void put(std::vector<std::byte>& out, T value) {
  std::array<std::byte, sizeof(T)> bytes;
  std::memcpy(bytes.data(), &value, sizeof(T));
  out.insert(out.end(), bytes.begin(), bytes.end());
}

double dot(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double length(const Vector3& a) {
  return std::sqrt(dot(a, a));
}
Vector3 scaled(const Vector3& a, double by) {
  return {a[0] * by, a[1] * by, a[2] * by};
}

struct Sphere {
  Vector3 centre{};
  double radius = 0;
};
Sphere sphere_around(const std::vector<Vector3>& points) {
  Vector3 low = points.front(), high = low;
  for (const Vector3& p : points) {
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], p[i]);
      high[i] = std::max(high[i], p[i]);
    }
  }
  Sphere sphere;
  for (std::size_t i = 0; i < 3; ++i) sphere.centre[i] = (low[i] + high[i]) / 2;
  for (const Vector3& p : points)
    sphere.radius = std::max(
        sphere.radius, std::hypot(p[0] - sphere.centre[0], p[1] - sphere.centre[1], p[2] - sphere.centre[2]));
  return sphere;
}

/// The point that is below the horizon where all points are (Ring 2013, "Computing the horizon occlusion
/// point"), in the space where the ellipsoid is a unit sphere. A tile that spans half the body has none: its
/// point is as far away as makes no difference.
Vector3 horizon_occlusion_point(const std::vector<Vector3>& points, const Vector3& centre,
                                const Ellipsoid& ellipsoid) {
  constexpr double kFarAway = 1e4;
  const double a = ellipsoid.semi_major_m, b = ellipsoid.semi_minor_m;
  const auto to_sphere = [a, b](const Vector3& p) { return Vector3{p[0] / a, p[1] / a, p[2] / b}; };
  const Vector3 towards = scaled(to_sphere(centre), 1 / length(to_sphere(centre)));
  double magnitude = 1;
  for (const Vector3& p : points) {
    const Vector3 on_sphere = to_sphere(p);
    const double distance = length(on_sphere);
    const Vector3 direction = scaled(on_sphere, 1 / distance);
    const double above = std::max(1.0, distance);
    const double cos_alpha = dot(direction, towards), sin_alpha = length(cross(direction, towards));
    const double cos_beta = 1 / above, sin_beta = std::sqrt(above * above - 1) * cos_beta;
    const double inverse = cos_alpha * cos_beta - sin_alpha * sin_beta;
    magnitude = inverse > 1 / kFarAway ? std::max(magnitude, 1 / inverse) : kFarAway;
    if (magnitude == kFarAway) break;
  }
  return scaled(towards, magnitude);
}

std::array<std::uint8_t, 2> oct_encoded(const Vector3& normal) {
  const double sum = std::abs(normal[0]) + std::abs(normal[1]) + std::abs(normal[2]);
  double x = normal[0] / sum, y = normal[1] / sum;
  if (normal[2] < 0) {
    const double folded_x = (1 - std::abs(y)) * (x < 0 ? -1 : 1);
    y = (1 - std::abs(x)) * (y < 0 ? -1 : 1);
    x = folded_x;
  }
  const auto byte = [](double v) {
    return static_cast<std::uint8_t>(std::lround((std::clamp(v, -1.0, 1.0) * 0.5 + 0.5) * 255));
  };
  return {byte(x), byte(y)};
}

/// Triangles along a Z curve and vertices by their first use.
struct Order {
  std::vector<std::array<std::uint32_t, 3>> triangles;  // by new numbers
  std::vector<std::uint32_t> old_of_new;
};
Order order_of(const QuantizedMesh& mesh) {
  std::vector<std::uint64_t> keys;
  keys.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    std::uint64_t u = 0, v = 0;
    for (const std::uint32_t i : t) {
      u += mesh.u[i];
      v += mesh.v[i];
    }
    keys.push_back(z_curve(u, v));
  }
  std::vector<std::uint32_t> sorted(mesh.triangles.size());
  std::iota(sorted.begin(), sorted.end(), 0u);
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return keys[a] < keys[b]; });
  Order order;
  constexpr std::uint32_t kNew = UINT32_MAX;
  std::vector<std::uint32_t> new_of_old(mesh.u.size(), kNew);
  const auto number = [&](std::uint32_t old) {
    if (new_of_old[old] == kNew) {
      new_of_old[old] = static_cast<std::uint32_t>(order.old_of_new.size());
      order.old_of_new.push_back(old);
    }
    return new_of_old[old];
  };
  for (const std::uint32_t t : sorted) {
    const auto& corners = mesh.triangles[t];
    const std::uint32_t a = number(corners[0]), b = number(corners[1]), c = number(corners[2]);
    order.triangles.push_back({a, b, c});
  }
  return order;
}

void put_header(const QuantizedMesh& mesh, std::vector<std::byte>& out) {
  std::vector<Vector3> points(mesh.u.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] = geocentric(mesh.place(i), mesh.metres(i), mesh.ellipsoid);
  const Sphere sphere = sphere_around(points);
  for (const double c : sphere.centre) put(out, c);
  put(out, mesh.lowest_m);
  put(out, mesh.highest_m);
  for (const double c : sphere.centre) put(out, c);
  put(out, sphere.radius);
  const LonLat middle{(mesh.bounds.west + mesh.bounds.east) / 2, (mesh.bounds.south + mesh.bounds.north) / 2};
  for (const double c :
       horizon_occlusion_point(points, geocentric(middle, 0, mesh.ellipsoid), mesh.ellipsoid))
    put(out, c);
}

void put_deltas(const std::vector<std::uint16_t>& values, const std::vector<std::uint32_t>& order,
                std::vector<std::byte>& out) {
  int before = 0;
  for (const std::uint32_t i : order) {
    const int delta = values[i] - before;
    before = values[i];
    put(out, static_cast<std::uint16_t>((delta << 1) ^ (delta >> 31)));
  }
}

template <class Index>
void put_triangles(const Order& order, std::vector<std::byte>& out) {
  while (out.size() % sizeof(Index) != 0) out.push_back(std::byte{0});
  put(out, static_cast<std::uint32_t>(order.triangles.size()));
  std::uint32_t highest = 0;
  for (const auto& triangle : order.triangles) {
    for (const std::uint32_t i : triangle) {
      put(out, static_cast<Index>(highest - i));
      if (i == highest) ++highest;
    }
  }
}

/// The vertices whose coordinate `across` has this value, ascending along the edge.
template <class Index>
void put_edge(const Order& order, const std::vector<std::uint16_t>& across, int value,
              const std::vector<std::uint16_t>& along, std::vector<std::byte>& out) {
  std::vector<std::uint32_t> edge;
  for (std::uint32_t i = 0; i < order.old_of_new.size(); ++i)
    if (across[order.old_of_new[i]] == value) edge.push_back(i);
  std::sort(edge.begin(), edge.end(), [&](std::uint32_t a, std::uint32_t b) {
    return along[order.old_of_new[a]] < along[order.old_of_new[b]];
  });
  put(out, static_cast<std::uint32_t>(edge.size()));
  for (const std::uint32_t i : edge) put(out, static_cast<Index>(i));
}

template <class Index>
void put_indices(const QuantizedMesh& mesh, const Order& order, std::vector<std::byte>& out) {
  put_triangles<Index>(order, out);
  put_edge<Index>(order, mesh.u, 0, mesh.v, out);
  put_edge<Index>(order, mesh.v, 0, mesh.u, out);
  put_edge<Index>(order, mesh.u, QuantizedMesh::kLargest, mesh.v, out);
  put_edge<Index>(order, mesh.v, QuantizedMesh::kLargest, mesh.u, out);
}

std::string metadata_of(const QuantizedMesh& mesh) {
  nlohmann::ordered_json json = {{"geometricerror", mesh.error_m}};
  for (const auto& level : mesh.available) {
    auto ranges = nlohmann::ordered_json::array();
    for (const TileRange& r : level) ranges.push_back(json_of(r));
    json["available"].push_back(ranges);
  }
  return json.dump();
}

}  // namespace

double QuantizedMesh::metres(std::size_t vertex) const {
  const double low = static_cast<double>(lowest_m), high = static_cast<double>(highest_m);
  return low + height[vertex] * (high - low) / kLargest;
}

LonLat QuantizedMesh::place(std::size_t vertex) const {
  return {bounds.west + bounds.width() * u[vertex] / kLargest,
          bounds.south + bounds.height() * v[vertex] / kLargest};
}

std::vector<std::byte> encode_quantized_mesh(const QuantizedMesh& mesh) {
  const Order order = order_of(mesh);
  std::vector<std::byte> out;
  out.reserve(128 + 8 * mesh.u.size() + 6 * mesh.triangles.size());
  put_header(mesh, out);
  put(out, static_cast<std::uint32_t>(order.old_of_new.size()));
  put_deltas(mesh.u, order.old_of_new, out);
  put_deltas(mesh.v, order.old_of_new, out);
  put_deltas(mesh.height, order.old_of_new, out);
  if (order.old_of_new.size() > kMost16BitVertices) {
    put_indices<std::uint32_t>(mesh, order, out);
  } else {
    put_indices<std::uint16_t>(mesh, order, out);
  }
  put(out, kNormalsExtension);
  put(out, static_cast<std::uint32_t>(2 * order.old_of_new.size()));
  for (const std::uint32_t i : order.old_of_new)
    for (const std::uint8_t byte : oct_encoded(mesh.normals[i])) put(out, byte);
  const std::string metadata = metadata_of(mesh);
  put(out, kMetadataExtension);
  put(out, static_cast<std::uint32_t>(metadata.size() + 4));
  put(out, static_cast<std::uint32_t>(metadata.size()));
  for (const char c : metadata) put(out, c);
  return out;
}

}  // namespace cairn
