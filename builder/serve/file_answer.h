#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "builder/serve/http_message.h"

namespace cairn {

/// A file as it is served.
struct ServedFile {
  std::shared_ptr<const File> file;
  std::uint64_t bytes = 0;
  std::string etag;  ///< strong, with its quotation marks
  std::string content_type;
  std::string cache_control;
};

/// What a Range field asks for of a file.
struct RangeWish {
  enum class Kind { whole, part, unsatisfiable } kind = Kind::whole;
  std::uint64_t first = 0;
  std::uint64_t bytes = 0;
};

/// Reads a Range field (RFC 9110, section 14.2). An empty one, and one of another unit than bytes, ask for
/// the whole file. One that is malformed, names several ranges, or begins behind the file's end is
/// unsatisfiable: a reader of ranges must not be sent a whole file by mistake.
RangeWish parse_range(const std::string& field, std::uint64_t file_bytes);

/// Answers a request for a file or a range of it: 200, 206, 304, 412 or 416, by the request's If-Match,
/// If-None-Match, If-Range and Range.
HttpAnswer answer_with_file(const HttpRequest& request, const ServedFile& served);

/// Returns whether a list of entity tags names this one, or is a star.
bool names_etag(const std::string& list, const std::string& etag);

}  // namespace cairn
