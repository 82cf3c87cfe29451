#include "builder/raster/pam_sidecar.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <string>

#include <fmt/format.h>

#include "builder/raster/crs.h"

namespace cairn {
namespace {

constexpr std::streamsize kMostBytes = 4 << 20;  // histograms and metadata make some large

// The text of the first element of that name, which holds no other elements; nullopt where there is none.
std::optional<std::string_view> element(std::string_view xml, std::string_view name) {
  for (std::size_t at = xml.find('<'); at != std::string_view::npos; at = xml.find('<', at + 1)) {
    const std::string_view tag = xml.substr(at + 1);
    if (!tag.starts_with(name) || tag.size() == name.size()) continue;
    const char after = tag[name.size()];
    if (after != '>' && after != ' ' && after != '/' && after != '\n' && after != '\t') continue;
    const std::size_t open_end = tag.find('>'), close = tag.find("</", open_end);
    if (open_end == std::string_view::npos || tag[open_end - 1] == '/') return std::nullopt;
    if (close == std::string_view::npos) return std::nullopt;
    return tag.substr(open_end + 1, close - open_end - 1);
  }
  return std::nullopt;
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::optional<double> number(std::optional<std::string_view> text) {
  if (!text) return std::nullopt;
  std::string_view digits = trimmed(*text);
  if (digits.starts_with('+')) digits.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  return error == std::errc() && end == digits.data() + digits.size() ? std::optional(value) : std::nullopt;
}

// What stands inside <PAMRasterBand band="N">; empty where the side-car says nothing of the band.
std::string_view part_of_band(std::string_view xml, int band) {
  constexpr std::string_view kOpen = "<PAMRasterBand";
  const std::string wanted = fmt::format("band=\"{}\"", band);
  for (std::size_t at = xml.find(kOpen); at != std::string_view::npos; at = xml.find(kOpen, at + 1)) {
    const std::size_t open_end = xml.find('>', at), close = xml.find("</PAMRasterBand>", at);
    if (open_end == std::string_view::npos || close == std::string_view::npos || open_end > close) return {};
    if (xml.substr(at, open_end - at).find(wanted) == std::string_view::npos) continue;
    return xml.substr(open_end + 1, close - open_end - 1);
  }
  return {};
}

}  // namespace

PamSidecar parse_pam(std::string_view xml, int band) {
  PamSidecar pam;
  const std::string_view of_band = part_of_band(xml, band);
  pam.nodata = number(element(of_band, "NoDataValue"));
  pam.scale = number(element(of_band, "Scale"));
  pam.offset = number(element(of_band, "Offset"));
  if (const auto unit = element(of_band, "UnitType")) pam.unit = std::string(trimmed(*unit));
  pam.places = element(xml, "GeoTransform") || element(xml, "SRS");
  return pam;
}

PamSidecar read_pam_beside(const std::filesystem::path& file, int band) {
  std::ifstream in(std::filesystem::path(file).concat(".aux.xml"), std::ios::binary);
  if (!in) return {};
  std::string text(static_cast<std::size_t>(kMostBytes), '\0');
  in.read(text.data(), kMostBytes);
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(in.gcount(), 0)));
  return parse_pam(text, band);
}

void apply_pam(const PamSidecar& pam, HeightTags& tags) {
  if (pam.nodata) tags.nodata = pam.nodata;
  if (pam.scale) tags.scale = *pam.scale;
  if (pam.offset) tags.offset = *pam.offset;
  if (!pam.unit || pam.unit->empty()) return;
  tags.unit = *pam.unit;
  tags.metres = metres_of_unit(*pam.unit);
}

}  // namespace cairn
