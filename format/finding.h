#pragma once

#include <string>

namespace cairn {

/// One thing that is wrong with a pack.
struct Finding {
  std::string where;  ///< "header", "index", "metadata", "blocks", or a tile as "heights 2/833/507"
  std::string what;   ///< expected X, found Y
};

}  // namespace cairn
