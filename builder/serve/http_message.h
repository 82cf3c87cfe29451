#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "format/file.h"

namespace cairn {

/// A request for a resource: GET or HEAD. The server has answered all others itself.
struct HttpRequest {
  std::string path;                           ///< its escapes decoded; begins with a slash
  std::map<std::string, std::string> query;   ///< decoded; the last of equal names
  std::map<std::string, std::string> fields;  ///< names in lower case

  /// Returns a field's value, empty where it is absent.
  const std::string& field(const std::string& lower_name) const;
};

/// The part of a file that an answer has as its body.
struct FilePart {
  std::shared_ptr<const File> file;
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
};

struct HttpAnswer {
  int status = 200;
  std::vector<std::pair<std::string, std::string>> fields;
  std::string body;
  std::optional<FilePart> file;  ///< instead of `body`
  /// Where there is one, nothing is answered: it takes over the connection's socket and answers itself.
  std::function<void(int socket)> take_socket = {};
};

/// Answers a request. Several threads call it at once.
using HttpHandler = std::function<HttpAnswer(const HttpRequest&)>;

/// Splits and decodes the target of a request line. Returns nullopt where it does not begin with a slash or
/// has a wrong escape, an escaped zero or a control character.
std::optional<HttpRequest> parse_target(const std::string& target);

/// Returns an answer with the JSON object {"error": text}.
HttpAnswer error_answer(int status, const std::string& text);

HttpAnswer json_answer(std::string json);

}  // namespace cairn
