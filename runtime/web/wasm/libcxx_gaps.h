#pragma once

// Included before all else: what of C++20's library format/ uses and Debian's Emscripten, with libc++ of LLVM
// 13, lacks.

#include <cstddef>
#include <cstring>
#include <memory>
#include <type_traits>

#if defined(__EMSCRIPTEN__)
namespace std {

template <class To, class From>
To bit_cast(const From& from) {
  static_assert(sizeof(To) == sizeof(From));
  To to;
  memcpy(&to, &from, sizeof to);
  return to;
}

template <class T>
unique_ptr<T> make_unique_for_overwrite(size_t count) {
  return unique_ptr<T>(new remove_extent_t<T>[count]);
}

}  // namespace std
#endif
