#pragma once

#include <string>
#include <string_view>

#include "cairn/pack_layout.h"

namespace cairn {

/// What a file says that its heights are measured from.
struct VerticalReference {
  std::string name;                              ///< as EPSG has it: "EGM96 height", "LN02 height", "WGS 84"
  VerticalDatum datum = VerticalDatum::unknown;  ///< where a pack has a word for it

  friend bool operator==(const VerticalReference&, const VerticalReference&) = default;
};

/// The reference of that name, whose datum is EGM96's if it says so.
VerticalReference vertical_reference_named(std::string_view name);

/// The reference of a vertical CRS or a geographic one in three dimensions by its EPSG code. The commonest
/// are known, PROJ is asked for others; what PROJ does not know is called by its code.
VerticalReference vertical_reference(int epsg);

/// Whether heights of both are measured from one surface.
bool is_one_datum(const VerticalReference& a, const VerticalReference& b);

}  // namespace cairn
