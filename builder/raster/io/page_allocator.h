#pragma once

#include <cstddef>
#include <new>
#include <utility>

#include <sys/mman.h>

namespace cairn {

/// Large blocks straight from the system, and back to it when freed. What caches hold for long and free at
/// any time would otherwise leave holes in the heap of whichever thread made it, which count against
/// --memory. Elements without a value are left without one.
template <class T>
struct PageAllocator {
  using value_type = T;

  PageAllocator() = default;
  template <class U>
  explicit PageAllocator(const PageAllocator<U>&) {}

  T* allocate(std::size_t count) {
    if (count * sizeof(T) < kLarge) return static_cast<T*>(::operator new(count * sizeof(T)));
    void* pages =
        ::mmap(nullptr, count * sizeof(T), PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (pages == MAP_FAILED) throw std::bad_alloc();
    return static_cast<T*>(pages);
  }
  void deallocate(T* pages, std::size_t count) {
    if (count * sizeof(T) < kLarge) return ::operator delete(pages);
    ::munmap(pages, count * sizeof(T));
  }

  void construct(T* element) { ::new (static_cast<void*>(element)) T; }
  template <class... Arguments>
  void construct(T* element, Arguments&&... arguments) {
    ::new (static_cast<void*>(element)) T(std::forward<Arguments>(arguments)...);
  }

  friend bool operator==(const PageAllocator&, const PageAllocator&) { return true; }

 private:
  static constexpr std::size_t kLarge = 64 << 10;
};

}  // namespace cairn
