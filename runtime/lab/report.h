#pragma once

#include <string>
#include <vector>

#include "runtime/lab/compare.h"

namespace cairn {

/// Returns the columns of to_csv(FrameRecord).
std::string csv_header();
std::string to_csv(const FrameRecord& record);

/// A summary of records: for each flight, method and tolerance the medians and worst cases of the frames.
struct CompareReport {
  std::string pack;  ///< its file's name
  std::string machine;
  std::vector<FrameRecord> records;
};
std::string to_json(const CompareReport& report);

/// Returns the processor's name and its number of threads, from /proc/cpuinfo.
std::string machine_name();

}  // namespace cairn
