#include <array>
#include <charconv>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "builder/objects/place_files.h"

namespace cairn {
namespace {

constexpr std::array<std::string_view, 7> kColumns{"lon",   "lat",    "model", "heading",
                                                   "scale", "height", "mode"};
enum Column : std::size_t { kLon, kLat, kModel, kHeading, kScale, kHeight, kMode };
constexpr std::string_view kMark = "\xEF\xBB\xBF";  // of byte order

std::string_view without_blanks(std::string_view text) {
  const auto is_space = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"') text = text.substr(1, text.size() - 2);
  return text;
}

void split(std::string_view line, std::vector<std::string_view>& fields) {
  fields.clear();
  for (std::size_t at = 0;;) {
    const std::size_t end = std::min(line.find(',', at), line.size());
    fields.push_back(without_blanks(line.substr(at, end - at)));
    if (end == line.size()) return;
    at = end + 1;
  }
}

Status read_number(std::string_view what, std::string_view text, double& value) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size()) return {};
  return bad_data(fmt::format("{}: expected a number, found '{}'", what, text.substr(0, 40)));
}

/// Which of kColumns each column of the file is.
Result<std::vector<std::size_t>> columns_of(std::string_view line) {
  std::vector<std::string_view> names;
  split(line, names);
  std::vector<std::size_t> columns;
  std::array<bool, kColumns.size()> there{};
  for (const std::string_view name : names) {
    std::size_t column = 0;
    while (column < kColumns.size() && kColumns[column] != name) ++column;
    if (column == kColumns.size() || there[column])
      return bad_data(
          fmt::format("expected columns lon,lat,model[,heading,scale,height,mode], each once, found '{}'",
                      name.substr(0, 40)));
    there[column] = true;
    columns.push_back(column);
  }
  if (!there[kLon] || !there[kLat] || !there[kModel])
    return bad_data(fmt::format("expected columns lon,lat,model[,heading,scale,height,mode], found {}",
                                line.substr(0, 80)));
  return columns;
}

// An optional field that is empty keeps its default.
Status set_field(std::size_t column, std::string_view text, ObjectPlace& place) {
  if (column == kModel) return place.model.assign(text), Status();
  if (column >= kHeading && text.empty()) return {};
  if (column == kMode) return set_mode(text, place);
  double* const numbers[] = {&place.at.lon,          &place.at.lat, nullptr,
                             &place.heading_degrees, &place.scale,  &place.height_m};
  return read_number(kColumns[column], text, *numbers[column]);
}

Status parse_line(const std::vector<std::size_t>& columns, const std::vector<std::string_view>& fields,
                  ObjectPlace& place) {
  if (fields.size() != columns.size())
    return bad_data(fmt::format("expected {} fields, found {}", columns.size(), fields.size()));
  place.heading_degrees = 0;
  place.scale = 1;
  place.height_m = 0;
  place.is_absolute = false;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (auto status = set_field(columns[i], fields[i], place); !status) return status;
  }
  return check_place(place);
}

}  // namespace

Status read_places_csv(const std::filesystem::path& file, const PlaceVisitor& visitor) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return failed(file.string() + ": expected a file that can be read, found none");
  std::string line;
  std::vector<std::size_t> columns;
  std::vector<std::string_view> fields;
  ObjectPlace place;
  for (std::uint64_t number = 1; std::getline(in, line); ++number) {
    const auto at_line = [&](const Error& error) {
      return Error{error.code, fmt::format("{}: line {}: {}", file.string(), number, error.message)};
    };
    std::string_view text = line;
    if (number == 1 && text.starts_with(kMark)) text.remove_prefix(kMark.size());
    if (without_blanks(text).empty()) continue;
    if (columns.empty()) {
      auto found = columns_of(text);
      if (!found) return at_line(found.error());
      columns = std::move(*found);
      continue;
    }
    split(text, fields);
    if (auto status = parse_line(columns, fields, place); !status) return at_line(status.error());
    if (auto status = visitor.place(place); !status) return at_line(status.error());
  }
  if (in.bad()) return failed(file.string() + ": expected a file that can be read, found an error");
  if (columns.empty()) return bad_data(file.string() + ": expected lines of places, found none");
  return {};
}

}  // namespace cairn
