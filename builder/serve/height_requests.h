#pragma once

#include <vector>

#include "builder/serve/http_message.h"
#include "builder/serve/served_pack.h"

namespace cairn {

/// Answers `lon` and `lat`, each one number or a list with commas, with the heights at these places: bilinear
/// in the finest tile, of the first pack that has one there, or of the one named `pack`. 400 for other
/// numbers and for more than a thousand places.
HttpAnswer answer_heights(const HttpRequest& request, const std::vector<ServedPack>& packs);

}  // namespace cairn
