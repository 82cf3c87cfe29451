#include "builder/app/points_csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <istream>
#include <optional>
#include <string_view>

namespace cairn {
namespace {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\"";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> fields;
  for (;;) {
    const std::size_t comma = line.find(',');
    fields.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

std::optional<double> number_in(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

Result<std::vector<CsvPoint>> PointsCsv::next(std::size_t most) {
  std::vector<CsvPoint> points;
  std::string line;
  while (points.size() < most && std::getline(in_, line)) {
    ++line_number_;
    if (trimmed(line).empty()) continue;
    if (line_number_ == 1 && !number_in(fields_of(line).front())) {
      if (const Status status = take_header(line); !status) return status.error();
      continue;
    }
    Result<CsvPoint> point = parse(line);
    if (!point) return point.error();
    points.push_back(std::move(*point));
  }
  return points;
}

Status PointsCsv::take_header(const std::string& line) {
  const auto names = fields_of(line);
  const auto lon = std::find(names.begin(), names.end(), "lon");
  const auto lat = std::find(names.begin(), names.end(), "lat");
  if (lon == names.end() || lat == names.end()) {
    return bad_data(name_ + ": line 1: expected columns lon,lat, found " + line);
  }
  lon_column_ = static_cast<std::size_t>(lon - names.begin());
  lat_column_ = static_cast<std::size_t>(lat - names.begin());
  return {};
}

Result<CsvPoint> PointsCsv::parse(const std::string& line) const {
  const auto fields = fields_of(line);
  if (fields.size() > std::max(lon_column_, lat_column_)) {
    const std::string_view lon = fields[lon_column_], lat = fields[lat_column_];
    const auto lon_value = number_in(lon), lat_value = number_in(lat);
    if (lon_value && lat_value) {
      return CsvPoint{{*lon_value, *lat_value}, std::string(lon), std::string(lat)};
    }
  }
  return bad_data(name_ + ": line " + std::to_string(line_number_) +
                  ": expected two numbers lon,lat, found " + line);
}

}  // namespace cairn
