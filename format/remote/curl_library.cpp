#include "format/remote/curl_library.h"

#include <dlfcn.h>

namespace cairn {
namespace {

template <class Function>
bool look_up(void* library, const char* name, Function& function) {
  function = reinterpret_cast<Function>(::dlsym(library, name));
  return function != nullptr;
}

// Kept for as long as the process lives: libcurl cannot be unloaded safely once TLS has started.
Result<CurlLibrary> load() {
  void* library = ::dlopen("libcurl.so.4", RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return failed("expected libcurl 4 to read a pack over HTTP, found none installed");
  CurlLibrary curl;
  const bool whole = look_up(library, "curl_global_init", curl.global_init) &&
                     look_up(library, "curl_easy_init", curl.easy_init) &&
                     look_up(library, "curl_easy_setopt", curl.easy_setopt) &&
                     look_up(library, "curl_easy_perform", curl.easy_perform) &&
                     look_up(library, "curl_easy_getinfo", curl.easy_getinfo) &&
                     look_up(library, "curl_easy_strerror", curl.easy_strerror) &&
                     look_up(library, "curl_easy_cleanup", curl.easy_cleanup);
  if (!whole || curl.global_init(CURL_GLOBAL_DEFAULT) != CURLE_OK)
    return failed("expected a libcurl 4 that starts, found another");
  return curl;
}

}  // namespace

Result<const CurlLibrary*> curl_library() {
  static const Result<CurlLibrary> library = load();
  if (!library) return library.error();
  return &*library;
}

}  // namespace cairn
