#include "runtime/stats/report.h"

#include <cstdio>
#include <map>
#include <set>
#include <sstream>

#include <nlohmann/json.hpp>

#include "runtime/stats/published_counts.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

template <class Items, class Field>
Summary summarize_field(const Items& items, Field field) {
  std::vector<double> samples;
  samples.reserve(items.size());
  for (const auto& item : items) samples.push_back(static_cast<double>(item.*field));
  return summarize(std::move(samples));
}

Json total_json(const PatternReport& report) {
  const Summary s = summarize_field(report.counts, &MoveCount::total);
  std::set<std::size_t> values;
  for (const MoveCount& count : report.counts) values.insert(count.total);
  return {{"min", static_cast<std::size_t>(s.min)},
          {"max", static_cast<std::size_t>(s.max)},
          {"mean", s.mean},
          {"values", values}};
}

Json difference_json(const PatternReport& report) {
  const Summary s = summarize_field(report.counts, &MoveCount::difference);
  std::map<std::size_t, std::size_t> histogram;
  for (const MoveCount& count : report.counts) ++histogram[count.difference];
  Json bins = Json::object();
  for (const auto& [difference, moves] : histogram) bins[std::to_string(difference)] = moves;
  return {{"min", static_cast<std::size_t>(s.min)},
          {"max", static_cast<std::size_t>(s.max)},
          {"mean", s.mean},
          {"p95", static_cast<std::size_t>(s.p95)},
          {"histogram", bins}};
}

std::optional<PublishedCounts> published_of(const PatternReport& report, int levels) {
  return report.pattern ? published_counts(*report.pattern, levels) : std::nullopt;
}

Json pattern_json(const PatternReport& report, int levels) {
  Json json{{"name", report.name()}, {"total", total_json(report)}, {"difference", difference_json(report)}};
  if (!report.pattern) json["error_px"] = report.error_px;
  if (const auto published = published_of(report, levels)) {
    json["published"] = {{"total_max", published->total}, {"difference_max", published->difference}};
  }
  if (report.loads.empty()) return json;
  const Summary ms = summarize_field(report.loads, &MoveLoad::latency_ms);
  json["latency_ms"] = {{"p50", ms.p50}, {"p95", ms.p95}, {"p99", ms.p99}, {"max", ms.max}};
  const Summary bytes = summarize_field(report.loads, &MoveLoad::bytes);
  json["bytes"] = {{"mean", bytes.mean},
                   {"p95", static_cast<std::uint64_t>(bytes.p95)},
                   {"max", static_cast<std::uint64_t>(bytes.max)}};
  return json;
}

}  // namespace

std::string to_json(const StatsReport& report) {
  Json json{{"levels", report.levels}, {"walk", report.walk}};
  json["moves"] = report.patterns.empty() ? 0 : report.patterns.front().counts.size();
  json["seed"] = report.seed;
  json["exhaustive"] = report.exhaustive;
  if (!report.pack.empty()) json["pack"] = report.pack;
  json["patterns"] = Json::array();
  for (const PatternReport& pattern : report.patterns)
    json["patterns"].push_back(pattern_json(pattern, report.levels));
  return json.dump(1) + "\n";
}

std::string to_csv(const StatsReport& report) {
  std::ostringstream out;
  out << "pattern,move,total,difference" << (report.pack.empty() ? "" : ",latency_ms,bytes") << "\n";
  for (const PatternReport& pattern : report.patterns) {
    for (std::size_t i = 0; i < pattern.counts.size(); ++i) {
      const MoveCount& count = pattern.counts[i];
      out << pattern.name() << "," << i + 1 << "," << count.total << "," << count.difference;
      if (!pattern.loads.empty()) out << "," << pattern.loads[i].latency_ms << "," << pattern.loads[i].bytes;
      out << "\n";
    }
  }
  return out.str();
}

std::string to_table(const StatsReport& report) {
  std::ostringstream out;
  char line[160];
  std::snprintf(line, sizeof line, "%-11s %5s %5s %7s   %5s %5s %7s   %s\n", "pattern", "min", "max", "mean",
                "diff", "p95", "mean", "Melkisetoglu: max total, max difference");
  out << line;
  for (const PatternReport& pattern : report.patterns) {
    const Summary total = summarize_field(pattern.counts, &MoveCount::total);
    const Summary difference = summarize_field(pattern.counts, &MoveCount::difference);
    const auto published = published_of(pattern, report.levels);
    const std::string theirs =
        published ? std::to_string(published->total) + ", " + std::to_string(published->difference) : "-";
    std::snprintf(line, sizeof line, "%-11s %5.0f %5.0f %7.2f   %5.0f %5.0f %7.2f   %s\n",
                  std::string(pattern.name()).c_str(), total.min, total.max, total.mean, difference.max,
                  difference.p95, difference.mean, theirs.c_str());
    out << line;
  }
  if (report.pack.empty()) return out.str();
  std::snprintf(line, sizeof line, "\n%-11s %9s %9s %9s %9s   %s\n", "pattern", "p50 ms", "p95 ms", "p99 ms",
                "max ms", "KiB a move");
  out << line;
  for (const PatternReport& pattern : report.patterns) {
    const Summary ms = summarize_field(pattern.loads, &MoveLoad::latency_ms);
    const Summary bytes = summarize_field(pattern.loads, &MoveLoad::bytes);
    std::snprintf(line, sizeof line, "%-11s %9.2f %9.2f %9.2f %9.2f   %.0f\n",
                  std::string(pattern.name()).c_str(), ms.p50, ms.p95, ms.p99, ms.max, bytes.mean / 1024);
    out << line;
  }
  for (const PatternReport& pattern : report.patterns) {
    if (pattern.pattern) continue;
    std::snprintf(line, sizeof line, "\nadaptive: the heights in view are off by %.2f pixels at most\n",
                  pattern.error_px);
    out << line;
  }
  return out.str();
}

}  // namespace cairn
