#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <optional>
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

/// Runs a script with Debian's Python.
Ran run_python(const std::vector<std::string>& arguments);

/// Runs it where no file may grow past so many bytes: writes past them fail, as on a full disk.
Ran run_cairn_on_full_disk(const std::vector<std::string>& arguments, std::size_t most_bytes);

/// Starts it, and kills it (as kill -9 does) after a while; whether it was still running.
bool run_cairn_and_kill(const std::vector<std::string>& arguments, std::chrono::milliseconds after);

/// Starts it, and interrupts it (as Ctrl-C does) once a file has grown past a header; nullopt where it ended
/// by itself.
std::optional<Ran> run_cairn_and_interrupt(const std::vector<std::string>& arguments,
                                           const std::filesystem::path& once_written);

/// A file's bytes; empty where it cannot be read.
std::string text_of(const std::filesystem::path& path);

/// Whether the text is exactly one line.
bool is_one_line(const std::string& text);

}  // namespace cairn::test
