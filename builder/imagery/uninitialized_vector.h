#pragma once

#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace cairn {

/// Leaves elements without a value where std::allocator would zero them.
template <class T>
struct UninitializedAllocator : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = UninitializedAllocator<U>;
  };
  template <class U>
  void construct(U* element) {
    ::new (static_cast<void*>(element)) U;
  }
  template <class U, class... Arguments>
  void construct(U* element, Arguments&&... arguments) {
    ::new (static_cast<void*>(element)) U(std::forward<Arguments>(arguments)...);
  }
};

/// A vector of plain numbers whose new elements must be written before they are read: pictures are filled at
/// once, and zeroing them first costs as much as a pass over them.
template <class T>
using UninitializedVector = std::vector<T, UninitializedAllocator<T>>;

}  // namespace cairn
