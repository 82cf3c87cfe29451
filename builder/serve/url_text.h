#pragma once

#include <string>

namespace cairn {

/// Returns the text as one segment of a URL's path: all but letters, digits and -._~ is escaped.
std::string escape_path(const std::string& text);

}  // namespace cairn
