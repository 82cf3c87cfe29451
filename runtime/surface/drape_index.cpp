#include "runtime/surface/drape_index.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <glm/geometric.hpp>

namespace cairn {
namespace {

constexpr double kMargin = 0.25;             // of a patch's width: lines that are as wide reach into it
constexpr std::size_t kMostKept = 1u << 14;  // patches and areas whose lines are kept

struct Box {
  glm::dvec2 low, high;
};

Box box_around(const TileId& area) {
  const GeoBounds b = tile_bounds(area);
  const glm::dvec2 margin(kMargin * b.width());
  return {glm::dvec2(b.west, b.south) - margin, glm::dvec2(b.east, b.north) + margin};
}

/// The part of a piece that lies in a box, as shares of the piece (Liang & Barsky 1984).
std::optional<glm::dvec2> share_in(const glm::dvec2& from, const glm::dvec2& to, const Box& box) {
  double first = 0, last = 1;
  for (int axis = 0; axis < 2; ++axis) {
    const double way = to[axis] - from[axis];
    if (way == 0) {
      if (from[axis] < box.low[axis] || from[axis] > box.high[axis]) return std::nullopt;
      continue;
    }
    const double a = (box.low[axis] - from[axis]) / way, b = (box.high[axis] - from[axis]) / way;
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  if (first > last) return std::nullopt;
  return glm::dvec2(first, last);
}

}  // namespace

DrapeIndex::DrapeIndex(std::shared_ptr<const Drape> drape) : drape_(std::move(drape)) {
  places_.reserve(drape_->lines.size());
  for (const DrapedLine& line : drape_->lines) {
    std::vector<glm::dvec2>& places = places_.emplace_back();
    for (const LonLat& at : line.places) {
      const double lon = places.empty() ? std::remainder(at.lon, 360.0)
                                        : places.back().x + std::remainder(at.lon - places.back().x, 360.0);
      places.emplace_back(lon, at.lat);
    }
    if (places.size() == 1) places.push_back(places.front());
  }
}

glm::dvec2 DrapeIndex::place(const Run& run, std::uint32_t index) const {
  return places_[run.line][index] + glm::dvec2(run.turn_deg, 0);
}

const std::vector<DrapeIndex::Run>& DrapeIndex::runs_in(const TileId& area) {
  if (const auto found = runs_.find(area); found != runs_.end()) return found->second;
  std::vector<Run> within;
  if (area.level > kMinLevel) {
    within = runs_in(parent_of(area));
  } else {
    for (std::uint32_t line = 0; line < places_.size(); ++line) {
      const std::vector<glm::dvec2>& places = places_[line];
      if (places.empty()) continue;
      const auto [west, east] = std::minmax_element(
          places.begin(), places.end(), [](const glm::dvec2& a, const glm::dvec2& b) { return a.x < b.x; });
      const GeoBounds b = tile_bounds(area);
      // A line that goes round the Earth is there once for each turn.
      for (double turn = std::floor((b.west - east->x) / 360) * 360; west->x + turn <= b.east; turn += 360) {
        within.push_back({line, 0, static_cast<std::uint32_t>(places.size() - 2), turn});
      }
    }
  }
  const Box box = box_around(area);
  std::vector<Run> runs;
  for (const Run& run : within) {
    for (std::uint32_t i = run.first; i <= run.last; ++i) {
      if (!share_in(place(run, i), place(run, i + 1), box)) continue;
      const bool goes_on = !runs.empty() && runs.back().line == run.line &&
                           runs.back().turn_deg == run.turn_deg && runs.back().last + 1 == i;
      if (goes_on) {
        runs.back().last = i;
      } else {
        runs.push_back({run.line, i, i, run.turn_deg});
      }
    }
  }
  return runs_[area] = std::move(runs);
}

void DrapeIndex::append(const Run& run, const TileId& patch, double least,
                        std::vector<DrapedSegment>& out) const {
  const GeoBounds b = tile_bounds(patch);
  const Box box = box_around(patch);
  const glm::dvec2 corner(b.west, b.south);
  const DrapedLine& line = drape_->lines[run.line];
  glm::dvec2 from = place(run, run.first);
  for (std::uint32_t i = run.first; i <= run.last; ++i) {
    const glm::dvec2 to = place(run, i + 1);
    if (i < run.last && glm::distance(from, to) < least * b.width()) continue;
    if (const auto share = share_in(from, to, box)) {
      const glm::dvec2 a = (glm::mix(from, to, share->x) - corner) / b.width(),
                       c = (glm::mix(from, to, share->y) - corner) / b.width();
      out.push_back({glm::vec4(a, c), glm::vec4(line.colour, line.width_px)});
    }
    from = to;
  }
}

std::span<const DrapedSegment> DrapeIndex::in(const TileId& patch, double least) {
  if (runs_.size() > kMostKept) runs_.clear();
  if (kept_.size() > kMostKept) kept_.clear();
  const int log2 = std::clamp(static_cast<int>(std::floor(std::log2(std::max(least, 1e-9)))), -30, 0);
  const auto [kept, is_new] = kept_.try_emplace(patch);
  if (is_new || kept->second.least_log2 != log2) {
    kept->second = {log2, {}};
    for (const Run& run : runs_in(patch)) append(run, patch, std::ldexp(1.0, log2), kept->second.segments);
  }
  return kept->second.segments;
}

}  // namespace cairn
