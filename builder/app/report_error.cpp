#include "builder/app/report_error.h"

#include <cstdio>

#include <fmt/core.h>

namespace cairn {

int report_error(const Error& error) {
  fmt::print(stderr, "cairn: {}\n", error.message);
  return static_cast<int>(error.code);
}

}  // namespace cairn
