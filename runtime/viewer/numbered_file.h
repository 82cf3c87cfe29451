#pragma once

#include <cstdio>
#include <memory>
#include <string>

#include "cairn/status.h"

namespace cairn::viewer {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

/// A file that this program has made, open for writing.
struct NumberedFile {
  std::string name;
  int number = 0;
  std::unique_ptr<std::FILE, CloseFile> file;
};

/// Makes the first file PREFIX-N.SUFFIX in the working folder that is not there yet, N from `first` on. An
/// existing file is never opened.
Result<NumberedFile> create_numbered(const std::string& prefix, const std::string& suffix, int first);

}  // namespace cairn::viewer
