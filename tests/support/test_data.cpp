#include "tests/support/test_data.h"

#include <cstdlib>
#include <stdexcept>
#include <string>
#include <system_error>

#include <catch2/catch.hpp>
#include <stdlib.h>

namespace cairn::test {

namespace fs = std::filesystem;

std::optional<fs::path> real_data() {
  const char* named = std::getenv("CAIRN_DATA");
  const fs::path folder = named != nullptr ? fs::path(named) : fs::path(CAIRN_SOURCE_DIR) / "../shared/data";
  if (fs::is_directory(folder)) return fs::canonical(folder);
  WARN("SKIPPED, nothing was checked: no test data at " << folder << "; set CAIRN_DATA");
  return std::nullopt;
}

fs::path sample_dem() {
  return fs::path(CAIRN_SOURCE_DIR) / "sample-dem";
}

TempDir::TempDir() {
  std::string name = (fs::temp_directory_path() / "cairn-test-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("mkdtemp failed: " + name);
  path_ = name;
}

TempDir::~TempDir() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

}  // namespace cairn::test
