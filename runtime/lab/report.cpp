#include "runtime/lab/report.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>
#include <thread>
#include <tuple>

#include <nlohmann/json.hpp>

#include "runtime/paging/frame_stats.h"

namespace cairn {
namespace {

using nlohmann::ordered_json;

struct Column {
  const char* name;
  double (*value)(const FrameRecord&);
};

template <class T>
double number(T value) {
  return static_cast<double>(value);
}

/// All numbers of a record; what was not measured is -1.
constexpr Column kColumns[] = {
    {"pitch_deg", [](const FrameRecord& r) { return r.pitch_deg; }},
    {"map_triangles", [](const FrameRecord& r) { return number(r.map_triangles); }},
    {"triangles", [](const FrameRecord& r) { return number(r.triangles); }},
    {"useful_triangles", [](const FrameRecord& r) { return number(r.error.useful_triangles); }},
    {"vertices", [](const FrameRecord& r) { return number(r.vertices); }},
    {"index_bytes", [](const FrameRecord& r) { return number(r.index_bytes); }},
    {"own_indices", [](const FrameRecord& r) { return number(r.strip_indices); }},
    {"batches", [](const FrameRecord& r) { return number(r.batches); }},
    {"selection_ms", [](const FrameRecord& r) { return r.selection_ms; }},
    {"building_ms", [](const FrameRecord& r) { return r.building_ms; }},
    {"cpu_ms", [](const FrameRecord& r) { return r.selection_ms + r.building_ms; }},
    {"preparing_ms", [](const FrameRecord& r) { return r.preparing_ms; }},
    {"max_px", [](const FrameRecord& r) { return r.error.max_px; }},
    {"rms_px", [](const FrameRecord& r) { return r.error.rms_px; }},
    {"samples", [](const FrameRecord& r) { return number(r.error.samples); }},
    {"holes", [](const FrameRecord& r) { return number(r.error.holes); }},
    {"pop_px", [](const FrameRecord& r) { return r.joins ? r.error.max_pop_px : -1; }},
    {"keeps", [](const FrameRecord& r) { return number(r.keeps_tolerance); }},
    {"tiles", [](const FrameRecord& r) { return number(r.tiles); }},
    {"new_tiles", [](const FrameRecord& r) { return r.frame > 0 ? number(r.new_tiles) : -1; }},
    {"useful_tiles", [](const FrameRecord& r) { return number(r.useful_tiles); }},
    {"resident_bytes", [](const FrameRecord& r) { return number(r.resident_bytes); }},
    {"loaded_bytes", [](const FrameRecord& r) { return number(r.loaded_bytes); }},
    {"useful_loaded_bytes", [](const FrameRecord& r) { return number(r.useful_loaded_bytes); }},
    {"cracks", [](const FrameRecord& r) { return r.faults ? number(r.faults->cracks) : -1; }},
    {"degenerate", [](const FrameRecord& r) { return r.faults ? number(r.faults->degenerate) : -1; }},
    {"worst_lon", [](const FrameRecord& r) { return place_of(r.error.worst).lon; }},
    {"worst_lat", [](const FrameRecord& r) { return place_of(r.error.worst).lat; }},
};

ordered_json summary_of(const std::vector<const FrameRecord*>& frames) {
  ordered_json out;
  for (const Column& column : kColumns) {
    std::vector<double> values;
    for (const FrameRecord* frame : frames) {
      const double value = column.value(*frame);
      if (value >= 0 || column.name == std::string_view("pitch_deg")) values.push_back(value);
    }
    const Summary s = summarize(values);
    out[column.name] = {{"p50", s.p50}, {"mean", s.mean}, {"max", s.max}};
  }
  const auto kept =
      std::count_if(frames.begin(), frames.end(), [](const auto* f) { return f->keeps_tolerance; });
  out["frames"] = frames.size();
  out["violations"] = frames.size() - static_cast<std::size_t>(kept);
  return out;
}

}  // namespace

std::string csv_header() {
  std::string header = "flight,method,tolerance_px,frame";
  for (const Column& column : kColumns) header += std::string(",") + column.name;
  return header + "\n";
}

std::string to_csv(const FrameRecord& record) {
  char number_text[32];
  const auto text = [&](double value) {
    std::snprintf(number_text, sizeof number_text, "%.9g", value);
    return std::string(number_text);
  };
  std::string line = record.flight;
  const auto append = [&](const std::string& cell) { line.append(1, ',').append(cell); };
  append(record.method);
  append(text(record.tolerance_px));
  append(std::to_string(record.frame));
  for (const Column& column : kColumns) append(text(column.value(record)));
  return line + "\n";
}

std::string to_json(const CompareReport& report) {
  using Key = std::tuple<std::string, std::string, double>;
  std::map<Key, std::vector<const FrameRecord*>> groups;
  for (const FrameRecord& r : report.records) groups[{r.flight, r.method, r.tolerance_px}].push_back(&r);
  ordered_json out{{"pack", report.pack}, {"machine", report.machine}, {"results", ordered_json::array()}};
  for (const auto& [key, frames] : groups) {
    ordered_json result{
        {"flight", std::get<0>(key)}, {"method", std::get<1>(key)}, {"tolerance_px", std::get<2>(key)}};
    result.update(summary_of(frames));
    out["results"].push_back(std::move(result));
  }
  return out.dump(1) + "\n";
}

std::string machine_name() {
  std::ifstream in("/proc/cpuinfo");
  std::string name = "unknown processor";
  for (std::string line; std::getline(in, line);) {
    if (line.rfind("model name", 0) != 0) continue;
    name = line.substr(line.find(':') + 2);
    break;
  }
  return name + ", " + std::to_string(std::thread::hardware_concurrency()) + " threads";
}

}  // namespace cairn
