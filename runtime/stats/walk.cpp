#include "runtime/stats/walk.h"

#include <array>
#include <cassert>
#include <charconv>
#include <fstream>
#include <optional>
#include <random>
#include <string>

namespace cairn {
namespace {

constexpr std::array<Move, 8> kMoves{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, 1}, {1, -1}, {-1, -1}}};

std::optional<Move> parse_move(std::string_view line) {
  Move move;
  const char* end = line.data() + line.size();
  const auto x = std::from_chars(line.data(), end, move.dx);
  if (x.ec != std::errc() || x.ptr == end || *x.ptr != ',') return std::nullopt;
  const auto y = std::from_chars(x.ptr + 1, end, move.dy);
  if (y.ec != std::errc() || y.ptr != end) return std::nullopt;
  return move;
}

}  // namespace

std::span<const Move> moves_of_kind(std::string_view kind) {
  const std::span<const Move> all{kMoves};
  if (kind == "axis") return all.first(4);
  if (kind == "diagonal") return all.last(4);
  if (kind == "random") return all;
  return {};
}

std::vector<Move> random_walk(std::span<const Move> kinds, std::size_t count, std::uint64_t seed) {
  assert(!kinds.empty());
  std::mt19937_64 random(seed);
  std::vector<Move> walk(count);
  for (Move& move : walk) move = kinds[random() % kinds.size()];
  return walk;
}

Result<std::vector<Move>> read_walk(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) return failed(path.string() + ": cannot be opened");
  std::vector<Move> walk;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (line.empty() || line.front() == '#') continue;
    const auto move = parse_move(line);
    if (!move) {
      return bad_data(path.string() + ": line " + std::to_string(number) + ": expected dx,dy, found " + line);
    }
    walk.push_back(*move);
  }
  if (file.bad()) return failed(path.string() + ": cannot be read");
  return walk;
}

TileId moved(const TileId& eye, const Move& move) {
  const TileId there = neighbour_of(eye, move.dx, move.dy);
  return is_valid(there) ? there : eye;
}

}  // namespace cairn
