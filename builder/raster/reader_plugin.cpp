#include "builder/raster/reader_plugin.h"

#include <filesystem>
#include <string>
#include <system_error>

#include <dlfcn.h>

namespace cairn {

namespace {

namespace fs = std::filesystem;

/// The folder of the program or of the shared library that this code is part of.
fs::path own_folder() {
  Dl_info self{};
  std::error_code error;
  if (::dladdr(reinterpret_cast<const void*>(&load_reader_plugin), &self) == 0) return {};
  return fs::canonical(self.dli_fname, error).parent_path();
}

}  // namespace

void* load_reader_plugin(const char* name, const char* entry) {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error).parent_path();
  const std::string file = std::string(name) + ".so";
  for (const fs::path& folder : {own_folder(), program, program / "../" CAIRN_LIBDIR "/cairn"}) {
    // Never closed: rasters that it opened may outlive any owner there could be.
    void* module = folder.empty() ? nullptr : ::dlopen((folder / file).c_str(), RTLD_NOW | RTLD_LOCAL);
    if (module != nullptr) return ::dlsym(module, entry);
  }
  return nullptr;
}

}  // namespace cairn
