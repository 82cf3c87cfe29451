#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/lod/mesh/lod_scene.h"
#include "runtime/lod/mesh/tile_window.h"

namespace cairn {

/// Numbers the samples that a tile's triangles use, in the order of their first use.
class VertexNumbers {
 public:
  /// Begins a tile's mesh. REQUIRES: window and mesh outlive the calls of number().
  void begin(const TileWindow& window, LodTileMesh& mesh) {
    for (const std::size_t slot : used_) numbers_[slot] = kNone;
    used_.clear();
    window_ = &window;
    mesh_ = &mesh;
    side_ = static_cast<std::size_t>(window.cells()) + 1;
    if (numbers_.size() < side_ * side_) numbers_.resize(side_ * side_, kNone);
  }

  /// Returns the number of the window's sample (c, r); adds it to the mesh's vertices at the first call.
  std::uint32_t number(int c, int r) {
    const std::size_t slot = static_cast<std::size_t>(r) * side_ + static_cast<std::size_t>(c);
    if (numbers_[slot] == kNone) {
      numbers_[slot] = static_cast<std::uint32_t>(mesh_->vertices.size());
      mesh_->vertices.push_back(window_->vertex(c, r));
      used_.push_back(slot);
    }
    return numbers_[slot];
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  std::vector<std::uint32_t> numbers_;
  std::vector<std::size_t> used_;
  const TileWindow* window_ = nullptr;
  LodTileMesh* mesh_ = nullptr;
  std::size_t side_ = 0;
};

}  // namespace cairn
