#include "runtime/surface/patch_mesh.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "format/rqt_steps.h"

namespace cairn {

PatchVertices::PatchVertices(const SurfacePatch& patch)
    : patch_(patch),
      samples_log2_(patch.sample_cells_log2()),
      spacing_(lattice_width(patch.area.level + patch.cells_log2)),
      corner_(south_west_of(patch.area)) {
  if (!patch.surface.tile || samples_log2_ < 0) return;
  const TileId& tile = patch.surface.tile->id;
  const int deeper = patch.area.level - tile.level;
  column_ = (patch.area.x - (tile.x << deeper)) << samples_log2_;
  row_ = (patch.area.y - (tile.y << deeper)) << samples_log2_;
}

ShownHeight PatchVertices::height(int i, int j) const {
  const SurfaceTile& tile = *patch_.surface.tile;
  const bool is_whole = patch_.surface.detail == tile.id.level && samples_log2_ == patch_.cells_log2;
  if (is_whole) {
    const int column = column_ + i, row = row_ + j;
    return {static_cast<float>(tile.heights->at(column, row)) * static_cast<float>(tile.quantum_m), 0,
            tile.heights->is_void(column, row)};
  }
  return shown_height_at(patch_.surface, {corner_.x + i * spacing_, corner_.y + j * spacing_});
}

PatchVertices::Vertex PatchVertices::at(int i, int j) const {
  const ShownHeight shown = patch_.surface.tile ? height(i, j) : ShownHeight{};
  const bool has_tables = patch_.surface.tile && samples_log2_ == patch_.cells_log2;
  const ColumnEntry column = has_tables ? patch_.surface.tile->columns[static_cast<std::size_t>(column_ + i)]
                                        : column_entry(corner_.x + i * spacing_);
  const RowEntry row = has_tables ? patch_.surface.tile->rows[static_cast<std::size_t>(row_ + j)]
                                  : row_entry(corner_.y + j * spacing_, patch_.ellipsoid);
  const glm::dvec3 position = position_of(column, row, static_cast<double>(shown.finer_m));
  const glm::vec3 high(position);
  const int to_side = 15 - patch_.cells_log2;
  return {{high, glm::vec3(position - glm::dvec3(high)), shown.finer_m, shown.to_coarser_m,
           static_cast<std::uint16_t>(i << to_side), static_cast<std::uint16_t>(j << to_side)},
          shown.is_void};
}

namespace {

constexpr std::uint16_t kNone = 0xFFFF;

}  // namespace

PatchTriangulation::PatchTriangulation(const SurfacePatch& patch, const SideVertices& sides)
    : patch_(patch), size_(patch.cells() + 1), rising_(root_rises(patch.area)) {
  std::fill_n(is_vertex_.begin(), static_cast<std::ptrdiff_t>(size_) * size_, std::uint8_t{0});
  take_own();
  take_forced();
  take_sides(sides);
}

std::array<PatchTriangulation::Triangle, 2> PatchTriangulation::halves() const {
  const Corner sw{0, 0}, se{size_ - 1, 0}, ne{size_ - 1, size_ - 1}, nw{0, size_ - 1};
  if (rising_) return {{{sw, ne, nw}, {ne, sw, se}}};
  return {{{se, nw, sw}, {nw, se, ne}}};
}

std::optional<PatchTriangulation::Corner> PatchTriangulation::middle_of(const Triangle& triangle) const {
  const int columns = triangle.from.column + triangle.to.column, rows = triangle.from.row + triangle.to.row;
  if (((columns | rows) & 1) != 0 || !is_vertex_[index(columns / 2, rows / 2)]) return std::nullopt;
  return Corner{columns / 2, rows / 2};
}

PatchTriangulation::Triangle PatchTriangulation::triangle_at(double column, double row) const {
  // Twice the signed area of the triangle that a place makes with two corners.
  const auto side_of = [](const Corner& a, const Corner& b, double x, double y) {
    return (b.column - a.column) * (y - a.row) - (b.row - a.row) * (x - a.column);
  };
  Triangle now = halves()[0];
  if (side_of(now.from, now.to, column, row) < 0) now = halves()[1];
  while (const std::optional<Corner> middle = middle_of(now)) {
    const bool is_beside_from =
        side_of(now.apex, *middle, column, row) * side_of(now.apex, *middle, now.from.column, now.from.row) >=
        0;
    now = is_beside_from ? Triangle{now.apex, now.from, *middle} : Triangle{now.to, now.apex, *middle};
  }
  return now;
}

void PatchTriangulation::take_own() {
  const int samples_log2 = patch_.sample_cells_log2();
  if (!patch_.surface.tile || samples_log2 <= 0) return;
  const TileId& tile = patch_.surface.tile->id;
  const int deeper = patch_.area.level - tile.level, samples = 1 << samples_log2;
  const int finer = patch_.cells_log2 - samples_log2;
  const int column = (patch_.area.x - (tile.x << deeper)) * samples;
  const int row = (patch_.area.y - (tile.y << deeper)) * samples;
  for (int j = 0; j <= samples; ++j) {
    const std::uint8_t* codes = patch_.surface.tile->steps.row_of(row + j) + column;
    std::uint8_t* out = &is_vertex_[index(0, j << finer)];
    for (int i = 0; i <= samples; ++i) out[i << finer] = codes[i] > patch_.step ? 1 : 0;
  }
}

void PatchTriangulation::take_forced() {
  const int step = 1 << (patch_.cells_log2 - patch_.forced_log2);
  for (int row = 0; row < size_; row += step) {
    for (int column = 0; column < size_; column += step) is_vertex_[index(column, row)] = 1;
  }
}

void PatchTriangulation::take_sides(const SideVertices& sides) {
  for (int i = 1; i < size_ - 1; ++i) {
    if (of_side(sides, Side::south) >> i & 1) raise(i, 0);
    if (of_side(sides, Side::north) >> i & 1) raise(i, size_ - 1);
    if (of_side(sides, Side::west) >> i & 1) raise(0, i);
    if (of_side(sides, Side::east) >> i & 1) raise(size_ - 1, i);
  }
}

void PatchTriangulation::raise(int column, int row) {
  std::uint8_t& is_vertex = is_vertex_[index(column, row)];
  if (is_vertex) return;
  is_vertex = 1;
  const RqtNeeds needs = rqt_needs_of(column, row, size_, rising_);
  const auto across = static_cast<std::size_t>(size_);
  for (const std::size_t need : {needs.first, needs.second})
    raise(static_cast<int>(need % across), static_cast<int>(need / across));
}

namespace {

/// The vertices and triangles of one patch.
class MeshBuilder {
 public:
  MeshBuilder(const SurfacePatch& patch, const SideVertices& sides)
      : triangulation_(patch, sides), vertices_(patch) {
    const auto samples = static_cast<std::ptrdiff_t>(triangulation_.size()) * triangulation_.size();
    std::fill_n(numbers_.begin(), samples, kNone);
  }

  PatchMesh run() {
    for (const PatchTriangulation::Triangle& half : triangulation_.halves()) emit(half);
    return std::move(mesh_);
  }

 private:
  /// Of the triangle, or of what it is bisected into.
  void emit(const PatchTriangulation::Triangle& t) {
    if (const auto middle = triangulation_.middle_of(t)) {
      emit({t.apex, t.from, *middle});
      emit({t.to, t.apex, *middle});
      return;
    }
    for (const PatchTriangulation::Corner& corner : {t.from, t.to, t.apex})
      mesh_.indices.push_back(number(corner));
  }

  std::uint16_t number(const PatchTriangulation::Corner& corner) {
    std::uint16_t& number = numbers_[triangulation_.index(corner.column, corner.row)];
    if (number == kNone) {
      number = static_cast<std::uint16_t>(mesh_.vertices.size());
      mesh_.vertices.push_back(vertices_.at(corner.column, corner.row).vertex);
    }
    return number;
  }

  PatchTriangulation triangulation_;
  PatchVertices vertices_;
  // Of size × size samples; most patches are small, and what they do not use costs nothing.
  std::array<std::uint16_t, PatchTriangulation::kMostSamples> numbers_;
  PatchMesh mesh_;
};

}  // namespace

PatchMesh build_patch_mesh(const SurfacePatch& patch, const SideVertices& sides) {
  return MeshBuilder(patch, sides).run();
}

}  // namespace cairn
