#include "format/gdal/dataset_name.h"

#include <charconv>

namespace cairn {
namespace {

/// Takes what follows the last colon off the text; nullopt where there is no colon.
std::optional<std::string_view> take_last_part(std::string_view& text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return std::nullopt;
  const std::string_view part = text.substr(colon + 1);
  text = text.substr(0, colon);
  return part;
}

std::optional<int> number_of(std::string_view text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::optional<Layer> layer_of(std::string_view text) {
  for (const Layer layer : {Layer::heights, Layer::imagery})
    if (text == to_string(layer)) return layer;
  return std::nullopt;
}

}  // namespace

std::optional<DatasetName> parse_dataset_name(std::string_view name) {
  if (!name.starts_with(kNamePrefix)) return DatasetName{std::string(name), {}, {}};
  std::string_view rest = name.substr(kNamePrefix.size());
  DatasetName out;
  auto part = take_last_part(rest);
  if (part && number_of(*part)) {
    out.level = number_of(*part);
    part = take_last_part(rest);
  }
  if (!part) return std::nullopt;
  out.layer = layer_of(*part);
  if (rest.size() >= 2 && rest.front() == '"' && rest.back() == '"') rest = rest.substr(1, rest.size() - 2);
  out.file = rest;
  if (!out.layer || out.file.empty()) return std::nullopt;
  return out;
}

std::string subdataset_name(const std::string& file, Layer layer) {
  return std::string(kNamePrefix) + '"' + file + "\":" + to_string(layer);
}

}  // namespace cairn
