#pragma once

#include <optional>
#include <string>

namespace cairn {

/// What a latitude is the angle of with the equator's plane: the normal of the ellipsoid, or the way to the
/// body's centre. On a sphere they are one.
enum class LatitudeKind { planetographic, planetocentric };

/// Which way longitudes count.
enum class LongitudeSense { east, west };

/// What a user says of a source; it counts instead of what the file says. Absent fields change nothing.
struct SourceOverrides {
  std::optional<int> band = std::nullopt;          ///< the band that holds the heights, from 1
  std::optional<double> nodata = std::nullopt;     ///< compared with the sample, before scale and offset
  std::optional<double> scale = std::nullopt;      ///< height in the unit = sample · scale + offset
  std::optional<double> offset = std::nullopt;     ///< in the unit
  std::optional<std::string> unit = std::nullopt;  ///< by name: "m", "ft", "US survey foot" …
  std::optional<std::string> crs = std::nullopt;   ///< of the plane: "EPSG:2056", WKT or what else PROJ takes
  /// The body: its name, "NAME,a,b" or "a,b" with the semi-axes of the pack's ellipsoid in metres. A source
  /// in degrees that names no other body is on it.
  std::optional<std::string> body = std::nullopt;
  std::optional<LatitudeKind> latitude = std::nullopt;
  std::optional<LongitudeSense> longitude = std::nullopt;  ///< of a source in degrees
  /// Posts lower than this are raised to it: the noise of a sea at 0 m, say. Metres, before a geoid.
  std::optional<double> sea_clamp_m = std::nullopt;
  /// The samples of an image that become 0 and 255, linearly between; absent: 0 and the most of its bits.
  std::optional<double> black = std::nullopt;
  std::optional<double> white = std::nullopt;
  /// Sources of a higher number win over others, finer ones too; 0 where nothing is said.
  std::optional<int> priority = std::nullopt;

  friend bool operator==(const SourceOverrides&, const SourceOverrides&) = default;
};

/// What is said of all sources whose name matches a pattern.
struct SourceRule {
  std::string glob;  ///< of the file's name or its whole path, as in a shell; "*" is every source
  SourceOverrides overrides = {};

  friend bool operator==(const SourceRule&, const SourceRule&) = default;
};

}  // namespace cairn
