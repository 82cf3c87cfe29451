#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "runtime/gl/gl_handle.h"
#include "runtime/gl/slot_pool.h"
#include "runtime/surface/axis_table.h"

namespace cairn::gl {

/// The column (or row) tables that the patches of a frame use, in one buffer on the GPU; patches of one
/// column of tiles share one.
template <class Entry, std::vector<Entry> (*MakeTable)(int level, std::int32_t index, int tile_size)>
class AxisBuffer {
 public:
  explicit AxisBuffer(int tile_size) : tile_size_(tile_size) {}

  void begin_frame() { slots_.begin_frame(); }

  /// Where the table of tiles at `index` of the level begins, in entries.
  std::uint32_t first_entry(int level, std::int32_t index) {
    const TileId key{level, index, 0};
    std::optional<std::uint32_t> slot = slots_.find(key);
    if (!slot) slot = add(key);
    return *slot * static_cast<std::uint32_t>(tile_size_);
  }
  GLuint name() const { return buffer_.name(); }
  std::uint64_t bytes() const { return slots_.capacity() * table_bytes(); }

 private:
  std::uint64_t table_bytes() const { return static_cast<std::uint64_t>(tile_size_) * sizeof(Entry); }

  std::uint32_t add(const TileId& key) {
    std::optional<std::uint32_t> slot = slots_.take(key);
    if (!slot) {
      grow();
      slot = slots_.take(key);
    }
    const std::vector<Entry> table = MakeTable(key.level, key.x, tile_size_);
    glNamedBufferSubData(buffer_.name(), static_cast<GLintptr>(*slot * table_bytes()),
                         static_cast<GLsizeiptr>(table_bytes()), table.data());
    return *slot;
  }

  void grow() {
    const std::uint64_t old_bytes = bytes();
    slots_.grow(std::max(64u, slots_.capacity() * 2));
    Buffer larger = make_buffer();
    glNamedBufferStorage(larger.name(), static_cast<GLsizeiptr>(bytes()), nullptr, GL_DYNAMIC_STORAGE_BIT);
    if (old_bytes > 0) {
      glCopyNamedBufferSubData(buffer_.name(), larger.name(), 0, 0, static_cast<GLsizeiptr>(old_bytes));
    }
    buffer_ = std::move(larger);
  }

  int tile_size_;
  SlotPool<TileId> slots_;
  Buffer buffer_;
};

using ColumnBuffer = AxisBuffer<ColumnEntry, column_table>;
using RowBuffer = AxisBuffer<RowEntry, row_table>;

}  // namespace cairn::gl
