#pragma once

#include <string>
#include <vector>

#include "runtime/lab/compare.h"

namespace cairn {

/// The columns of to_csv, and a record's line.
std::string csv_header();
std::string to_csv(const FrameRecord& record);

/// What a set of packs, flights and records comes to: for each flight, method and tolerance the medians and
/// worst cases of the frames.
struct CompareReport {
  std::string pack;  ///< its file's name
  std::string machine;
  std::vector<FrameRecord> records;
};
std::string to_json(const CompareReport& report);

/// The processor's name and its number of threads, from /proc/cpuinfo.
std::string machine_name();

}  // namespace cairn
