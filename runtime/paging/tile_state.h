#pragma once

#include <cstdint>

namespace cairn {

/// Where a tile is on its way from the pack to the screen; docs/runtime-threads.md draws the ways between
/// the states.
enum class TileState : std::uint8_t {
  unknown,    ///< neither needed nor in memory
  wanted,     ///< needed; it is read when a worker is free
  under_way,  ///< being read
  stale,      ///< being read, though it is no longer needed
  pausing,    ///< needed; its read failed and is repeated after a pause
  resident,   ///< in memory, and not needed
  pinned,     ///< in memory, and drawn or about to be
  failing,    ///< absent for a while, as its reads go on failing: an ancestor is shown
  damaged,    ///< absent for good: an ancestor is shown
};

constexpr bool is_in_memory(TileState state) {
  return state == TileState::resident || state == TileState::pinned;
}
constexpr bool is_absent(TileState state) {
  return state == TileState::failing || state == TileState::damaged;
}
constexpr bool is_being_read(TileState state) {
  return state == TileState::under_way || state == TileState::stale;
}
/// Whether the tile is on its way into memory.
constexpr bool is_requested(TileState state) {
  return state == TileState::wanted || state == TileState::pausing || is_being_read(state);
}

}  // namespace cairn
