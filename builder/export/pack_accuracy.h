#pragma once

#include <optional>
#include <string>

#include "cairn/geo.h"
#include "cairn/pack_reader.h"

namespace cairn {

/// What a pack's metadata says of its heights.
struct PackAccuracy {
  /// What the finest surface is off the source posts at most: the error bound or what was measured, whichever
  /// is larger. Nothing where the metadata does not say.
  std::optional<double> finest_error_m;
  std::optional<GeoBounds> bounds;  ///< of what was baked
};
PackAccuracy accuracy_of(const PackReader& pack);

/// A word that differs where the packs differ: sixteen hexadecimal digits of the metadata's checksum.
std::string identity_of(const PackReader& pack);

}  // namespace cairn
