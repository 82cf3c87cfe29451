#include "builder/app/bake_progress.h"

#include <cstdio>

#include <fmt/format.h>
#include <unistd.h>

namespace cairn {
namespace {

using std::chrono::steady_clock;

std::string describe(const Progress& p, ProgressUnit unit, double seconds) {
  const double rate = seconds > 0 ? static_cast<double>(p.done) / seconds : 0;
  const double left = rate > 0 ? static_cast<double>(p.total - p.done) / rate : 0;
  const double percent =
      p.total > 0 ? 100.0 * static_cast<double>(p.done) / static_cast<double>(p.total) : 100.0;
  const std::string written =
      p.bytes_written > 0
          ? fmt::format("  {:.1f} MiB written", static_cast<double>(p.bytes_written) / 1048576.0)
          : "";
  const std::string speed =
      unit == ProgressUnit::samples ? fmt::format("  {:.1f} Msamples/s", rate / 1e6) : "";
  return fmt::format("{}: {:5.1f} %{}{}  {:.0f} s left", p.stage, percent, speed, written, left);
}

}  // namespace

BakeProgress::BakeProgress(ProgressUnit unit)
    : start_(steady_clock::now()), shown_(start_), unit_(unit), terminal_(::isatty(STDERR_FILENO) == 1) {}

BakeProgress::~BakeProgress() {
  if (line_open_) fmt::print(stderr, "\n");
}

void BakeProgress::show(const Progress& progress) {
  const auto now = steady_clock::now();
  const auto pause = terminal_ ? std::chrono::milliseconds(200) : std::chrono::milliseconds(10000);
  if (now - shown_ < pause) return;
  shown_ = now;
  const std::string line = describe(progress, unit_, std::chrono::duration<double>(now - start_).count());
  fmt::print(stderr, "{}{}{}", terminal_ ? "\r\x1b[K" : "", line, terminal_ ? "" : "\n");
  std::fflush(stderr);
  line_open_ = terminal_;
}

}  // namespace cairn
