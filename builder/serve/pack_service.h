#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "builder/serve/http_message.h"
#include "builder/serve/page_files.h"
#include "builder/serve/served_pack.h"
#include "builder/serve/stream_service.h"
#include "cairn/status.h"

namespace cairn {

/// What a server of packs answers: the page at /, a list of the packs at /packs.json, their bytes at
/// /packs/NAME, heights at /heights, tiles at /terrarium/NAME/ and /quantized-mesh/NAME/, and pictures at
/// /stream/NAME. Only the files that were named when it was opened can be reached. Any number of threads may
/// ask.
class PackService {
 public:
  /// `page` is the folder of the page's files, where there is one; without `streams`, pictures are refused.
  /// usage where two packs have one name.
  static Result<PackService> open(const std::vector<std::filesystem::path>& packs,
                                  const std::optional<std::filesystem::path>& page,
                                  std::unique_ptr<StreamService> streams = nullptr);

  HttpAnswer answer(const HttpRequest& request) const;

 private:
  HttpAnswer list() const;
  HttpAnswer answer_with_pack(const HttpRequest& request) const;
  const ServedPack* find(const std::string& name) const;

  std::vector<ServedPack> packs_;
  PageFiles page_;
  std::unique_ptr<StreamService> streams_;
};

}  // namespace cairn
