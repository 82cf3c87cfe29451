#pragma once

#include <filesystem>
#include <vector>

namespace cairn {

/// The objects of a bake.
struct ObjectOptions {
  std::vector<std::filesystem::path> places;  ///< CSV and GeoJSON; docs/objects.md has their columns
  std::filesystem::path models;               ///< the folder with the models that the places name
};

}  // namespace cairn
