#include "builder/app/points_csv.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <istream>
#include <string_view>

#include <fmt/format.h>

namespace cairn {
namespace {

constexpr std::size_t kMostComplaints = 10;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
constexpr std::array<std::string_view, 8> kLonNames{"lon", "longitude", "long",    "lng",
                                                    "x",   "lon_deg",   "x_coord", "point_x"};
constexpr std::array<std::string_view, 6> kLatNames{"lat", "latitude", "y", "lat_deg", "y_coord", "point_y"};

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

/// What the quotes at `at` enclose, where two quotes stand for one; `at` moves behind them.
std::string quoted(std::string_view line, std::size_t& at) {
  std::string text;
  for (++at; at < line.size(); ++at) {
    if (line[at] == '"' && (at + 1 == line.size() || line[at + 1] != '"')) return ++at, text;
    if (line[at] == '"') ++at;
    text += line[at];
  }
  return text;
}

std::vector<std::string> fields_of(std::string_view line, char separator) {
  if (separator != '\t') line = trimmed(line);
  std::vector<std::string> fields;
  for (std::size_t at = 0;; ++at) {
    while (at < line.size() && line[at] == ' ') ++at;
    std::string field = at < line.size() && line[at] == '"' ? quoted(line, at) : "";
    const std::size_t end = std::min(line.find(separator, at), line.size());
    field += trimmed(line.substr(at, end - at));
    fields.push_back(std::move(field));
    if (end == line.size()) return fields;
    at = end;
  }
}

std::optional<double> number_in(std::string text, bool decimal_comma) {
  if (text.starts_with('+')) text.erase(0, 1);
  if (decimal_comma && text.find('.') == std::string::npos) std::replace(text.begin(), text.end(), ',', '.');
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

char separator_of(std::string_view line) {
  for (const char candidate : {'\t', ';', ','})
    if (line.find(candidate) != std::string_view::npos) return candidate;
  return trimmed(line).find(' ') != std::string_view::npos ? ' ' : ',';
}

template <class Names>
std::size_t place_of(const std::vector<std::string>& fields, const Names& names) {
  const auto found = std::find_if(fields.begin(), fields.end(), [&](const std::string& field) {
    return std::find(names.begin(), names.end(), lower(field)) != names.end();
  });
  return static_cast<std::size_t>(found - fields.begin());
}

}  // namespace

std::string csv_field(const std::string& text, char separator) {
  if (text.find(separator) == std::string::npos && text.find('"') == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + '"';
}

Result<std::vector<CsvPoint>> PointsCsv::next(std::size_t most) {
  std::vector<CsvPoint> points;
  std::string line;
  while (points.size() < most && std::getline(in_, line)) {
    ++line_number_;
    if (line_number_ == 1 && line.starts_with(kByteOrderMark)) line.erase(0, kByteOrderMark.size());
    if (trimmed(line).empty()) continue;
    bool is_header = false;
    if (!begun_) {
      if (const Status status = begin(line, is_header); !status) return status.error();
    }
    if (is_header) continue;
    points.push_back(parse(line));
    if (!points.back().place) complain(line);
  }
  return points;
}

Status PointsCsv::begin(const std::string& line, bool& is_header) {
  begun_ = true;
  if (line.starts_with("\xFF\xFE") || line.starts_with("\xFE\xFF"))
    return bad_data(name_ + ": expected text in UTF-8, found UTF-16; save it as CSV UTF-8");
  separator_ = separator_of(line);
  const auto fields = fields_of(line, separator_);
  const bool commas = separator_ == ';' || separator_ == '\t';
  const bool named =
      place_of(fields, kLonNames) < fields.size() && place_of(fields, kLatNames) < fields.size();
  is_header = named || std::none_of(fields.begin(), fields.end(), [&](const std::string& field) {
                return number_in(field, commas).has_value();
              });
  if (is_header) return take_header(fields);
  if (!columns_.empty())
    return bad_data(
        fmt::format("{}: line {}: expected names of columns, found {}", name_, line_number_, line));
  for (std::size_t i = 2; i < fields.size(); ++i) other_names_.push_back(fmt::format("column{}", i + 1));
  return {};
}

Status PointsCsv::take_header(const std::vector<std::string>& names) {
  if (columns_.size() == 2) {
    lon_column_ = place_of(names, std::array{lower(columns_[0])});
    lat_column_ = place_of(names, std::array{lower(columns_[1])});
  } else {
    lon_column_ = place_of(names, kLonNames);
    lat_column_ = place_of(names, kLatNames);
  }
  if (lon_column_ >= names.size() || lat_column_ >= names.size()) {
    const std::string wanted =
        columns_.size() == 2 ? columns_[0] + "," + columns_[1] : "lon,lat (or longitude,latitude, or x,y)";
    return bad_data(fmt::format("{}: line {}: expected columns {}, found {}", name_, line_number_, wanted,
                                fmt::join(names, ",")));
  }
  for (std::size_t i = 0; i < names.size(); ++i)
    if (i != lon_column_ && i != lat_column_) other_names_.push_back(names[i]);
  return {};
}

CsvPoint PointsCsv::parse(const std::string& line) {
  auto fields = fields_of(line, separator_);
  CsvPoint point;
  if (lon_column_ < fields.size()) point.lon_text = fields[lon_column_];
  if (lat_column_ < fields.size()) point.lat_text = fields[lat_column_];
  const bool commas = separator_ == ';' || separator_ == '\t';
  const auto lon = number_in(point.lon_text, commas), lat = number_in(point.lat_text, commas);
  if (lon && lat) point.place = LonLat{*lon, *lat};
  decimal_commas_ = decimal_commas_ || (commas && (lon && point.lon_text.find(',') != std::string::npos));
  for (std::size_t i = 0; i < fields.size(); ++i)
    if (i != lon_column_ && i != lat_column_) point.others.push_back(std::move(fields[i]));
  point.others.resize(other_names_.size());
  return point;
}

void PointsCsv::complain(const std::string& line) {
  if (++bad_lines_ > kMostComplaints) return;
  complaints_.push_back(fmt::format("{}: line {}: expected two numbers lon,lat, found {}", name_,
                                    line_number_, trimmed(line).substr(0, 80)));
}

std::vector<std::string> PointsCsv::complaints() const {
  std::vector<std::string> all = complaints_;
  if (bad_lines_ > kMostComplaints)
    all.push_back(
        fmt::format("{}: {} more lines without two numbers lon,lat", name_, bad_lines_ - kMostComplaints));
  return all;
}

}  // namespace cairn
