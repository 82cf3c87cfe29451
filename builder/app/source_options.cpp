#include "builder/app/source_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>

#include <fmt/format.h>

#include "builder/app/one_of.h"
#include "builder/raster/body_placement.h"
#include "builder/raster/source_overrides.h"

namespace cairn {
namespace {

bool matches_any(const std::filesystem::path& file, const std::vector<std::string>& globs) {
  return std::any_of(globs.begin(), globs.end(),
                     [&](const std::string& glob) { return matches_glob(file, glob); });
}

template <class T>
bool read_number(std::string_view text, std::optional<T>& out) {
  T value{};
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return false;
  if (!std::isfinite(static_cast<double>(value))) return false;
  out = value;
  return true;
}

bool read_text(std::string_view text, std::optional<std::string>& out) {
  out = std::string(text);
  return !text.empty();
}

template <class Words, class T>
bool read_word(std::string_view text, const Words& words, std::optional<T>& out) {
  const auto found = words.find(std::string(text));
  if (found != words.end()) out = found->second;
  return found != words.end();
}

const std::map<std::string, LatitudeKind> kLatitudes{{"planetocentric", LatitudeKind::planetocentric},
                                                     {"planetographic", LatitudeKind::planetographic}};
const std::map<std::string, LongitudeSense> kLongitudes{{"east", LongitudeSense::east},
                                                        {"west", LongitudeSense::west}};

bool is_body(std::string_view text) {
  return parse_body(text).ok();
}

bool read_setting(std::string_view key, std::string_view value, SourceOverrides& said) {
  if (key == "band") return read_number(value, said.band);
  if (key == "nodata") return read_number(value, said.nodata);
  if (key == "scale") return read_number(value, said.scale);
  if (key == "offset") return read_number(value, said.offset);
  if (key == "unit") return read_text(value, said.unit);
  if (key == "crs") return read_text(value, said.crs);
  if (key == "body") return is_body(value) && read_text(value, said.body);
  if (key == "latitude") return read_word(value, kLatitudes, said.latitude);
  if (key == "longitude") return read_word(value, kLongitudes, said.longitude);
  if (key == "sea-clamp") return read_number(value, said.sea_clamp_m);
  if (key == "priority") return read_number(value, said.priority);
  return false;
}

// The next word of a line; what stands in quotes is one, also behind `key=`. Empty at the end of the line.
std::string next_word(std::istream& line) {
  std::string word;
  line >> std::ws;
  bool quoted = false;
  for (int c = line.get(); c != EOF; c = line.get()) {
    if (c == '"') {
      quoted = !quoted;
    } else if (!quoted && (c == ' ' || c == '\t' || c == '\r')) {
      break;
    } else if (!quoted && c == '#') {
      line.setstate(std::ios::eofbit);
      break;
    } else {
      word += static_cast<char>(c);
    }
  }
  return word;
}

}  // namespace

void add_source_options(CLI::App& verb, SourceArguments& arguments) {
  SourceOverrides& all = arguments.all;
  const CLI::Validator finite(
      [](const std::string& text) {
        std::optional<double> number;
        return read_number(text, number) ? std::string() : "expected a finite number, found " + text;
      },
      "");
  verb.add_option("--include", arguments.include, "of the DEMs, only files that match one of these patterns")
      ->allow_extra_args(false);
  verb.add_option("--exclude", arguments.exclude, "of the DEMs, no files that match one of these patterns")
      ->allow_extra_args(false);
  verb.add_option("--sources", arguments.file,
                  "file with a line for each pattern of DEMs: PATTERN, then any of band=, nodata=, scale=, "
                  "offset=, unit=, crs=, body=, latitude=, longitude=, sea-clamp=, priority=")
      ->check(CLI::ExistingFile);
  verb.add_option("--band", all.band, "band of the DEMs that holds the heights, from 1")
      ->check(CLI::Range(1, 65535));
  verb.add_option("--nodata", all.nodata, "sample that means a void, in place of what the DEMs say")
      ->check(finite);
  verb.add_option("--scale", all.scale,
                  "height in the unit = sample * scale + offset, in place of what the DEMs say")
      ->check(finite);
  verb.add_option("--offset", all.offset, "see --scale")->check(finite);
  verb.add_option("--unit", all.unit,
                  "unit of the heights (m, ft, US survey foot ...), in place of what the DEMs say");
  verb.add_option("--source-crs", all.crs,
                  "CRS of the DEMs as PROJ takes it (EPSG:2056, WKT), in place of what they say");
  verb.add_option("--sea-clamp", all.sea_clamp_m,
                  "metres: lower posts become it (0: the noise of a sea; land below the sea, too)")
      ->check(finite);
  const CLI::Validator body(
      [](const std::string& text) {
        const auto parsed = parse_body(text);
        return parsed ? std::string() : parsed.error().message;
      },
      "");
  verb.add_option(
          "--body", all.body,
          "body of all sources, images too, and semi-axes in metres of the pack's ellipsoid: NAME (Mars, "
          "Moon ...), NAME,a,b or a,b; by default what they say")
      ->check(body);
  verb.add_option("--latitude", all.latitude,
                  "what latitudes on an ellipsoid are, in place of what the sources say")
      ->transform(one_of(kLatitudes));
  verb.add_option("--longitude", all.longitude,
                  "which way longitudes count, in place of what the sources say (old Mars maps: west)")
      ->transform(one_of(kLongitudes));
}

Result<std::vector<SourceRule>> parse_source_rules(std::string_view text, const std::string& name) {
  std::vector<SourceRule> rules;
  std::istringstream lines{std::string(text)};
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::istringstream words(line);
    SourceRule rule;
    rule.glob = next_word(words);
    if (rule.glob.empty()) continue;
    for (std::string word = next_word(words); !word.empty(); word = next_word(words)) {
      const std::size_t equals = std::min(word.find('='), word.size());
      const std::string value = equals < word.size() ? word.substr(equals + 1) : "";
      if (!read_setting(word.substr(0, equals), value, rule.overrides))
        return usage_error(fmt::format(
            "{}: line {}: expected band=, nodata=, scale=, offset=, unit=, crs=, body=, latitude=, "
            "longitude=, sea-clamp= or priority= with a value, found {}",
            name, number, word));
    }
    if (rule.overrides == SourceOverrides{})
      return usage_error(fmt::format("{}: line {}: expected a setting after the pattern {}, found none", name,
                                     number, rule.glob));
    rules.push_back(std::move(rule));
  }
  return rules;
}

Result<std::vector<SourceRule>> source_rules(const SourceArguments& arguments) {
  std::vector<SourceRule> rules;
  if (arguments.all != SourceOverrides{}) rules.push_back({"*", arguments.all});
  if (arguments.file.empty()) return rules;
  std::ifstream in(arguments.file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  if (in.bad() || !in.is_open())
    return usage_error(arguments.file + ": expected a file that can be read, found none");
  auto of_file = parse_source_rules(text, arguments.file);
  if (!of_file) return of_file;
  rules.insert(rules.end(), of_file->begin(), of_file->end());
  return rules;
}

std::vector<SourceRule> image_rules(const SourceArguments& arguments, const std::vector<double>& range) {
  SourceOverrides place;
  place.body = arguments.all.body;
  place.latitude = arguments.all.latitude;
  place.longitude = arguments.all.longitude;
  if (!range.empty()) {
    place.black = range[0];
    place.white = range[1];
  }
  if (place == SourceOverrides{}) return {};
  return {{"*", place}};
}

Result<std::vector<std::filesystem::path>> chosen_files(std::vector<std::filesystem::path> files,
                                                        const SourceArguments& arguments) {
  const std::size_t before = files.size();
  std::erase_if(files, [&](const std::filesystem::path& file) {
    const bool included = arguments.include.empty() || matches_any(file, arguments.include);
    return !included || matches_any(file, arguments.exclude);
  });
  if (files.empty() && before > 0)
    return usage_error(
        fmt::format("expected DEMs that --include and --exclude leave, found none of {}", before));
  return files;
}

}  // namespace cairn
