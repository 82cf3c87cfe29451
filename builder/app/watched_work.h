#pragma once

#include "builder/app/bake_progress.h"
#include "builder/app/interrupt.h"
#include "builder/app/remedies.h"
#include "builder/app/report_error.h"
#include "cairn/progress.h"
#include "cairn/status.h"

namespace cairn {

/// Runs long work, which takes a ProgressCallback, with a line of progress. Ctrl-C ends it after the tiles at
/// work. `explain` makes of its error what is printed. Does not return where it was interrupted.
template <class Work, class Explain>
auto watched(const Work& work, const Explain& explain, ProgressUnit unit = ProgressUnit::samples) {
  const Interrupt interrupt;
  auto result = [&] {
    BakeProgress line(unit);
    return work([&](const Progress& p) {
      line.show(p);
      return !interrupt.is_asked();
    });
  }();
  if (result) return result;
  const Error error = explain(result.error());
  if (interrupt.is_asked()) report_error(error);
  interrupt.end_program();
  return decltype(result)(error);
}

}  // namespace cairn
