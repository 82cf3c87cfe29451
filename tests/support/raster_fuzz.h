#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace cairn::test {

/// Opens the bytes as a file of that name through one reader of builder/sources/ alone, and reads the first
/// and the last posts of what opens, as heights and as colours.
void open_and_read(const char* format, const std::string& name, std::span<const std::byte> bytes);

}  // namespace cairn::test
