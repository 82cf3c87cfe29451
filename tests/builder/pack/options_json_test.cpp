// Options as JSON: what the metadata states, the fingerprint hashes and `verify --against` reads back.

#include "builder/pack/options_json.h"

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

namespace cairn {
namespace {

using Change = std::pair<const char*, std::function<void(BuildOptions&)>>;

// One for each option that decides the bytes of a pack of heights and imagery.
std::vector<Change> deciding_changes() {
  return {
      {"tile_size", [](BuildOptions& o) { o.grid.tile_size = 257; }},
      {"top", [](BuildOptions& o) { o.grid.top = -9; }},
      {"region",
       [](BuildOptions& o) {
         o.grid.region = GeoBounds{-1.5, 2, 3.25, 4};
       }},
      {"level", [](BuildOptions& o) { o.mosaic.level = 5; }},
      {"max_error_m", [](BuildOptions& o) { o.mosaic.max_error_m = 0.1; }},
      {"resampling", [](BuildOptions& o) { o.mosaic.resampling = ResampleMethod::bilinear; }},
      {"resampling", [](BuildOptions& o) { o.mosaic.resampling = ResampleMethod::cubic; }},
      {"datum", [](BuildOptions& o) { o.mosaic.datum = VerticalDatum::egm96; }},
      {"fade", [](BuildOptions& o) { o.mosaic.fade_posts = 2.5; }},
      {"sources",
       [](BuildOptions& o) {
         o.mosaic.source_rules = {
             {"*", {.nodata = -1.0}},
             {"b_*",
              {.band = 2, .scale = 0.5, .offset = 3.0, .unit = "ft", .crs = "EPSG:2056", .priority = -4}}};
       }},
      {"geoid", [](BuildOptions& o) { o.mosaic.geoid = "geoid.tif"; }},
      {"quantum_m", [](BuildOptions& o) { o.heights.quantum_m = 0.3; }},
      {"voids", [](BuildOptions& o) { o.heights.voids = VoidMode::keep; }},
      {"rqt_tolerance_m", [](BuildOptions& o) { o.heights.rqt_tolerance_m = 1.5F; }},
      {"bounds",
       [](BuildOptions& o) {
         o.imagery.bounds = GeoBounds{1, 2, 3, 4};
       }},
      {"format", [](BuildOptions& o) { o.imagery.format = TextureFormat::bc7; }},
      {"quality", [](BuildOptions& o) { o.imagery.quality = TextureQuality::best; }},
      {"feather_pixels", [](BuildOptions& o) { o.imagery.feather_pixels = 0.1; }}};
}

BuildOptions with_images() {
  BuildOptions options;
  options.imagery.inputs = {"a.tif"};
  return options;
}

// As a reader of the metadata sees it.
Result<BuildOptions> read_back(const BuildOptions& options) {
  return from_json(nlohmann::json::parse(to_json(options).dump()));
}

}  // namespace

TEST_CASE("every option that decides a byte is in the JSON, and comes back from it") {
  const std::string defaults = to_json(with_images()).dump();
  for (const auto& [name, change] : deciding_changes()) {
    INFO(name);
    BuildOptions options = with_images();
    change(options);
    const std::string stated = to_json(options).dump();
    CHECK(stated != defaults);
    auto read = read_back(options);
    REQUIRE(read.ok());
    read->imagery.inputs = options.imagery.inputs;  // the files' names are not stated
    read->mosaic.geoid = options.mosaic.geoid;
    CHECK(to_json(*read).dump() == stated);
  }
}

TEST_CASE("options that decide no byte are not in the JSON") {
  const std::string defaults = to_json(BuildOptions()).dump();
  BuildOptions options;
  options.session = {"a.cairn", 1, 3, true, true};
  options.heights.allow_error = true;
  options.mosaic.inputs = {"a.hgt", "b.hgt"};
  CHECK(to_json(options).dump() == defaults);
}

TEST_CASE("JSON of options that is wrong is refused with the key, what was expected and what was found") {
  const auto message = [](const char* text) {
    const auto read = from_json(nlohmann::json::parse(text));
    REQUIRE_FALSE(read.ok());
    CHECK(read.error().code == ErrorCode::bad_data);
    return read.error().message;
  };
  CHECK(message("[]") == "options: expected an object, found another type");
  CHECK(message(R"({"void": "dig"})") == R"(options: void: expected one of fill, keep, found "dig")");
  CHECK(message(R"({"resampling": 3})") ==
        "options: resampling: expected one of nearest, bilinear, cubic, exact, smooth, found 3");
  CHECK(message(R"({"level": 1.5})") == "options: level: expected a whole number, found 1.5");
  CHECK(message(R"({"region": {"west": "x"}})") == R"(options: west: expected a number, found "x")");
  CHECK(message(R"({"imagery": {"quality": "good"}})") ==
        R"(options: quality: expected one of fast, normal, best, found "good")");
  CHECK(message(R"({"imagery": 1})") == "options: imagery: expected an object, found another type");
  CHECK(from_json(nlohmann::json::object()).ok());
}

}  // namespace cairn
