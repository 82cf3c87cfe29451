#pragma once

#include <string>
#include <vector>

namespace cairn::test {

struct Ran {
  int exit_code = -1;  ///< -1 where it did not exit by itself
  std::string out;
  std::string err;
};

/// Runs the `cairn` program that was built beside the tests; `input` is its stdin.
Ran run_cairn(const std::vector<std::string>& arguments, const std::string& input = "");

/// Whether the text is exactly one line.
bool is_one_line(const std::string& text);

}  // namespace cairn::test
