#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "cairn/status.h"

namespace cairn {

/// Takes the bytes of a file that is unpacked, piece by piece from the front.
using ByteSink = std::function<Status(std::span<const std::byte>)>;

}  // namespace cairn
