#pragma once

#include <string>
#include <string_view>

namespace cairn {

/// Text out of a file, made fit for a one-line message: control characters become '?', and it ends after 80
/// bytes.
inline std::string printable(std::string_view text) {
  std::string out(text.substr(0, 80));
  for (char& c : out)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '?';
  return out;
}

}  // namespace cairn
