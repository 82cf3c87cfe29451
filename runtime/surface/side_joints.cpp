#include "runtime/surface/side_joints.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "format/rqt_steps.h"

namespace cairn {
namespace {

constexpr std::uint64_t bit(std::int64_t i) {
  return std::uint64_t{1} << i;
}

/// Which vertices on the sides of a lattice each of them needs, directly or not. It depends on nothing but
/// the lattice's size.
class SideNeeds {
 public:
  explicit SideNeeds(int cells_log2) : cells_(1 << cells_log2), needs_(4 * static_cast<std::size_t>(cells_)) {
    for (const Side side : kSides) {
      for (int i = 1; i < cells_; ++i) {
        const auto [column, row] = place_of(side, i);
        collect(column, row, needs_[slot(side, i)]);
      }
    }
  }
  const SideVertices& of(Side side, int i) const { return needs_[slot(side, i)]; }

  static const SideNeeds& of_lattice(int cells_log2) {
    static const auto table = [] {
      std::vector<SideNeeds> all;
      for (int k = 0; k <= kPatchCellsLog2; ++k) all.emplace_back(k);
      return all;
    }();
    return table[static_cast<std::size_t>(cells_log2)];
  }

 private:
  std::size_t slot(Side side, int i) const {
    return static_cast<std::size_t>(side) * static_cast<std::size_t>(cells_) + static_cast<std::size_t>(i);
  }
  std::pair<int, int> place_of(Side side, int i) const {
    switch (side) {
      case Side::south:
        return {i, 0};
      case Side::north:
        return {i, cells_};
      case Side::west:
        return {0, i};
      default:
        return {cells_, i};
    }
  }

  void collect(int column, int row, SideVertices& found) const {
    const bool on_column = column == 0 || column == cells_, on_row = row == 0 || row == cells_;
    if (on_column && on_row) return;
    if (on_row) of_side(found, row == 0 ? Side::south : Side::north) |= bit(column);
    if (on_column) of_side(found, column == 0 ? Side::west : Side::east) |= bit(row);
    // The corners off the root's diagonal are always there, whichever way it runs.
    const RqtNeeds needs = rqt_needs_of(column, row, cells_ + 1, true);
    const auto across = static_cast<std::size_t>(cells_) + 1;
    for (const std::size_t need : {needs.first, needs.second})
      collect(static_cast<int>(need % across), static_cast<int>(need / across), found);
  }

  int cells_;
  std::vector<SideVertices> needs_;
};

/// The vertices that a patch's own triangulation has on a side.
std::uint64_t own_vertices(const SurfacePatch& patch, Side side) {
  std::uint64_t bits = 0;
  for (std::int64_t i = 1 << (patch.cells_log2 - patch.forced_log2), step = i; i < patch.cells(); i += step)
    bits |= bit(i);
  const int samples_log2 = patch.sample_cells_log2();
  if (!patch.surface.tile || samples_log2 <= 0) return bits;
  const TileId& tile = patch.surface.tile->id;
  const int samples = 1 << samples_log2, deeper = patch.area.level - tile.level;
  int column = (patch.area.x - (tile.x << deeper)) * samples,
      row = (patch.area.y - (tile.y << deeper)) * samples;
  if (side == Side::north) row += samples;
  if (side == Side::east) column += samples;
  const VertexSteps& steps = patch.surface.tile->steps;
  const std::uint64_t own = is_vertical(side) ? steps.along_column(column, row, samples, patch.step)
                                              : steps.along_row(column, row, samples, patch.step);
  const int finer = patch.cells_log2 - samples_log2;
  if (finer == 0) return bits | own;
  for (int i = 1; i < samples; ++i) bits |= (own >> i & 1) << (i << finer);
  return bits;
}

std::int64_t spacing_of(const SurfacePatch& patch) {
  return lattice_width(patch.area.level + patch.cells_log2);
}

/// Tiles agree along an edge, but not about what fills their voids.
bool agree_at_edges(const SurfaceTile& a, const SurfaceTile& b) {
  return &a == &b || (a.id.level == b.id.level && a.heights->voids.empty() && b.heights->voids.empty());
}

bool show_one_surface(const SurfacePatch& a, const SurfacePatch& b) {
  if (spacing_of(a) != spacing_of(b) || (a.surface.tile == nullptr) != (b.surface.tile == nullptr))
    return false;
  return !a.surface.tile ||
         (agree_at_edges(*a.surface.tile, *b.surface.tile) && a.surface.detail == b.surface.detail);
}

/// Where two patches have the same vertices.
struct Joint {
  std::size_t smaller = 0;
  std::size_t larger = 0;
  Side of_smaller = Side::south;
  std::uint8_t offset = 0;  ///< of the smaller one's first corner on the larger one's side
};

class Joiner {
 public:
  explicit Joiner(PatchPartition& partition) : partition_(partition), patches_(partition.patches) {}

  SideJoints run() {
    for (const SharedSegment& s : partition_.segments) {
      SurfacePatch& coarser = patches_[s.coarser];
      const int least = patches_[s.finer].area.level - coarser.area.level;
      coarser.cells_log2 = std::max(coarser.cells_log2, least);
    }
    joints_.sides.resize(patches_.size());
    for (std::size_t i = 0; i < patches_.size(); ++i) {
      for (const Side side : kSides) of_side(joints_.sides[i], side) = own_vertices(patches_[i], side);
    }
    std::vector<Joint> same;
    for (const SharedSegment& s : partition_.segments) {
      const SurfacePatch& coarser = patches_[s.coarser];
      const std::int64_t offset = (s.first - begin_of(coarser.area, s.coarser_side())) / spacing_of(coarser);
      if (show_one_surface(patches_[s.finer], coarser)) {
        same.push_back({s.finer, s.coarser, s.finer_side, static_cast<std::uint8_t>(offset)});
      } else {
        joints_.walled.push_back(s);
        add(s.coarser, s.coarser_side(), ends_of(s, coarser, offset));
      }
    }
    while (settle(same)) {
    }
    return std::move(joints_);
  }

 private:
  static std::uint64_t ends_of(const SharedSegment& s, const SurfacePatch& coarser, std::int64_t offset) {
    const std::int64_t end = offset + (s.last - s.first) / spacing_of(coarser);
    return (offset > 0 ? bit(offset) : 0) | (end < coarser.cells() ? bit(end) : 0);
  }

  /// Whether it changed anything.
  bool settle(const std::vector<Joint>& same) {
    bool changed = false;
    for (const Joint& joint : same) {
      const SurfacePatch& smaller = patches_[joint.smaller];
      const SurfacePatch& larger = patches_[joint.larger];
      const Side on_larger = opposite(joint.of_smaller);
      const std::uint64_t of_larger = of_side(joints_.sides[joint.larger], on_larger);
      const std::uint64_t of_smaller = of_side(joints_.sides[joint.smaller], joint.of_smaller);
      const std::uint64_t within = smaller.cells() == 64 ? ~bit(0) : (bit(smaller.cells()) - 1) & ~bit(0);
      const std::int64_t end = joint.offset + smaller.cells();
      std::uint64_t to_larger = of_smaller << joint.offset;
      if (joint.offset > 0) to_larger |= bit(joint.offset);
      if (end < larger.cells()) to_larger |= bit(end);
      changed |= add(joint.smaller, joint.of_smaller, of_larger >> joint.offset & within);
      changed |= add(joint.larger, on_larger, to_larger);
    }
    return changed;
  }

  /// Adds vertices to a side, with what they need.
  bool add(std::size_t patch, Side side, std::uint64_t bits) {
    SideVertices& sides = joints_.sides[patch];
    std::uint64_t fresh = bits & ~of_side(sides, side);
    if (fresh == 0) return false;
    const SideNeeds& needs = SideNeeds::of_lattice(patches_[patch].cells_log2);
    for (; fresh != 0; fresh &= fresh - 1) {
      const SideVertices& more = needs.of(side, std::countr_zero(fresh));
      for (std::size_t k = 0; k < sides.size(); ++k) sides[k] |= more[k];
    }
    return true;
  }

  PatchPartition& partition_;
  std::vector<SurfacePatch>& patches_;
  SideJoints joints_;
};

}  // namespace

SideJoints join_sides(PatchPartition& partition) {
  return Joiner(partition).run();
}

}  // namespace cairn
