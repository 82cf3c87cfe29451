#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "builder/serve/file_answer.h"
#include "cairn/status.h"

namespace cairn {

/// The files of the page in the browser. They are listed and opened once, so that no request leads to a path.
class PageFiles {
 public:
  /// Lists the files in a folder and those below it. Only regular files count, not links.
  static Result<PageFiles> open(const std::filesystem::path& folder);

  /// Answers a request for one of the files, "/" being index.html; nullopt where there is none.
  std::optional<HttpAnswer> answer(const HttpRequest& request) const;

 private:
  std::map<std::string, ServedFile> files_;  // by path from "/"
};

}  // namespace cairn
