#include "builder/serve/http_message.h"

#include <charconv>
#include <string_view>

#include <nlohmann/json.hpp>

namespace cairn {
namespace {

/// Returns the text without its escapes; nullopt where one is wrong or stands for a control character.
std::optional<std::string> unescape(std::string_view text, bool plus_is_space) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    unsigned char c = static_cast<unsigned char>(text[i]);
    if (c == '%') {
      unsigned value = 0;
      if (text.size() - i < 3) return std::nullopt;
      const char* digits = text.data() + i + 1;
      const auto read = std::from_chars(digits, digits + 2, value, 16);
      if (read.ec != std::errc() || read.ptr != digits + 2) return std::nullopt;
      c = static_cast<unsigned char>(value);
      i += 2;
    } else if (c == '+' && plus_is_space) {
      c = ' ';
    }
    if (c < 0x20 || c == 0x7F) return std::nullopt;
    out.push_back(static_cast<char>(c));
  }
  return out;
}

bool parse_query(std::string_view text, std::map<std::string, std::string>& query) {
  while (!text.empty()) {
    const std::size_t end = text.find('&');
    const std::string_view pair = text.substr(0, end);
    const std::size_t equals = pair.find('=');
    const auto name = unescape(pair.substr(0, equals), true);
    const auto value =
        unescape(equals == std::string_view::npos ? std::string_view() : pair.substr(equals + 1), true);
    if (!name || !value) return false;
    if (!name->empty()) query[*name] = *value;
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
  }
  return true;
}

}  // namespace

const std::string& HttpRequest::field(const std::string& lower_name) const {
  static const std::string none;
  const auto found = fields.find(lower_name);
  return found == fields.end() ? none : found->second;
}

std::optional<HttpRequest> parse_target(const std::string& target) {
  if (target.empty() || target.front() != '/') return std::nullopt;
  const std::string_view text(target);
  const std::size_t mark = text.find('?');
  const auto path = unescape(text.substr(0, mark), false);
  if (!path) return std::nullopt;
  HttpRequest request;
  request.path = *path;
  if (mark != std::string_view::npos && !parse_query(text.substr(mark + 1), request.query))
    return std::nullopt;
  return request;
}

HttpAnswer error_answer(int status, const std::string& text) {
  HttpAnswer answer = json_answer(
      nlohmann::json{{"error", text}}.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  answer.status = status;
  return answer;
}

HttpAnswer json_answer(std::string json) {
  return {200, {{"Content-Type", "application/json"}, {"Cache-Control", "no-cache"}}, std::move(json), {}};
}

}  // namespace cairn
