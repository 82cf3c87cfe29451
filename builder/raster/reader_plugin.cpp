#include "builder/raster/reader_plugin.h"

#include <filesystem>
#include <string>
#include <system_error>

#include <dlfcn.h>

namespace cairn {

void* load_reader_plugin(const char* name, const char* entry) {
  std::error_code error;
  const auto folder = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  for (const char* place : {"", "../" CAIRN_LIBDIR "/cairn/"}) {
    const std::string file = std::string(place) + name + ".so";
    // Never closed: rasters that it opened may outlive any owner there could be.
    void* module = ::dlopen((folder / file).c_str(), RTLD_NOW | RTLD_LOCAL);
    if (module != nullptr) return ::dlsym(module, entry);
  }
  return nullptr;
}

}  // namespace cairn
