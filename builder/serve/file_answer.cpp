#include "builder/serve/file_answer.h"

#include <algorithm>
#include <limits>
#include <string_view>

#include <fmt/format.h>

namespace cairn {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

/// Returns a number of decimal digits, the largest there is where it does not fit; nullopt where the text is
/// none.
std::optional<std::uint64_t> number(std::string_view text) {
  if (text.empty()) return std::nullopt;
  std::uint64_t value = 0;
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
  for (const char c : text) {
    if (c < '0' || c > '9') return std::nullopt;
    const auto digit = static_cast<std::uint64_t>(c - '0');
    value = value > (kMost - digit) / 10 ? kMost : value * 10 + digit;
  }
  return value;
}

bool is_bytes_unit(std::string_view unit) {
  constexpr std::string_view kBytes = "bytes";
  return std::equal(unit.begin(), unit.end(), kBytes.begin(), kBytes.end(),
                    [](char a, char b) { return (a | 0x20) == b; });
}

HttpAnswer with_fields(int status, const ServedFile& served) {
  return {status,
          {{"ETag", served.etag}, {"Cache-Control", served.cache_control}, {"Accept-Ranges", "bytes"}},
          {},
          {}};
}

}  // namespace

RangeWish parse_range(const std::string& field, std::uint64_t file_bytes) {
  const std::size_t equals = field.find('=');
  if (equals == std::string::npos)
    return {field.empty() ? RangeWish::Kind::whole : RangeWish::Kind::unsatisfiable, 0, 0};
  const std::string_view text(field);
  if (!is_bytes_unit(trimmed(text.substr(0, equals)))) return {};
  const std::string_view range = trimmed(text.substr(equals + 1));
  const std::size_t dash = range.find('-');
  constexpr RangeWish kNone{RangeWish::Kind::unsatisfiable, 0, 0};
  if (dash == std::string_view::npos) return kNone;
  const auto first = number(trimmed(range.substr(0, dash)));
  const auto last = number(trimmed(range.substr(dash + 1)));
  if (dash == 0) {  // so many bytes at the end
    if (!last || *last == 0 || file_bytes == 0) return kNone;
    const std::uint64_t bytes = std::min(*last, file_bytes);
    return {RangeWish::Kind::part, file_bytes - bytes, bytes};
  }
  const bool open = dash + 1 == range.size();
  if (!first || *first >= file_bytes || (!open && (!last || *last < *first))) return kNone;
  const std::uint64_t end = open ? file_bytes - 1 : std::min(*last, file_bytes - 1);
  return {RangeWish::Kind::part, *first, end - *first + 1};
}

bool names_etag(const std::string& list, const std::string& etag) {
  std::string_view rest(list);
  while (true) {
    const std::size_t comma = rest.find(',');
    const std::string_view one = trimmed(rest.substr(0, comma));
    if (one == "*" || one == etag) return true;
    if (comma == std::string_view::npos) return false;
    rest = rest.substr(comma + 1);
  }
}

HttpAnswer answer_with_file(const HttpRequest& request, const ServedFile& served) {
  if (const std::string& wanted = request.field("if-match");
      !wanted.empty() && !names_etag(wanted, served.etag))
    return with_fields(412, served);
  if (const std::string& known = request.field("if-none-match");
      !known.empty() && names_etag(known, served.etag))
    return with_fields(304, served);
  const std::string& if_range = request.field("if-range");
  const RangeWish wish = if_range.empty() || trimmed(if_range) == served.etag
                             ? parse_range(request.field("range"), served.bytes)
                             : RangeWish{};
  if (wish.kind == RangeWish::Kind::unsatisfiable) {
    HttpAnswer answer = with_fields(416, served);
    answer.fields.emplace_back("Content-Range", fmt::format("bytes */{}", served.bytes));
    return answer;
  }
  const bool whole = wish.kind == RangeWish::Kind::whole;
  HttpAnswer answer = with_fields(whole ? 200 : 206, served);
  answer.fields.emplace_back("Content-Type", served.content_type);
  answer.file =
      whole ? FilePart{served.file, 0, served.bytes} : FilePart{served.file, wish.first, wish.bytes};
  if (!whole)
    answer.fields.emplace_back("Content-Range", fmt::format("bytes {}-{}/{}", wish.first,
                                                            wish.first + wish.bytes - 1, served.bytes));
  return answer;
}

}  // namespace cairn
