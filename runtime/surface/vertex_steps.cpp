#include "runtime/surface/vertex_steps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "format/rqt_steps.h"
#include "runtime/surface/vertex_errors.h"

namespace cairn {
namespace {

constexpr double kFinest_m = 0.002;  // of tolerances: a hundredth of what packs store heights to
constexpr int kMostCode = 127;       // so that a code and a step add up within a byte
constexpr int kColumnStep = 16;
constexpr std::size_t kBeyond = 8;  // bytes that a line's last word may read beyond it

const std::array<double, kMostCode + 1>& tolerances_m() {
  static const auto table = [] {
    std::array<double, kMostCode + 1> t{};
    for (int k = 0; k <= kMostCode; ++k) {
      t[static_cast<std::size_t>(k)] =
          kFinest_m * std::exp2(static_cast<double>(k) / VertexSteps::kPerOctave);
    }
    return t;
  }();
  return table;
}

std::uint8_t code_of(float error_m) {
  const auto& table = tolerances_m();
  const auto reached = std::upper_bound(table.begin(), table.end() - 1, static_cast<double>(error_m));
  return static_cast<std::uint8_t>(reached - table.begin());
}

/// Gives every vertex a code no less than that of any vertex that needs it, from the finest to the coarsest.
void pass_on_to_needed(std::vector<std::uint8_t>& codes, int size, bool rising) {
  const int last = size - 1;
  const auto at = [&](int column, int row) -> std::uint8_t& {
    return codes[static_cast<std::size_t>(row) * static_cast<std::size_t>(size) +
                 static_cast<std::size_t>(column)];
  };
  const auto raise = [](std::uint8_t& code, std::uint8_t to) { code = std::max(code, to); };
  for (int s = 2; s <= last; s *= 2) {
    const int h = s / 2;
    for (int r = h; r < last; r += s) {
      for (int c = h; c < last; c += s) {
        // The middles of the square's edges need its centre, the centre the corners off its diagonal.
        std::uint8_t& centre = at(c, r);
        raise(centre, std::max({at(c, r - h), at(c, r + h), at(c - h, r), at(c + h, r)}));
        const int d = diagonal_rises(rising, size, c - h, r - h, s) ? h : -h;
        raise(at(c + d, r - h), centre);
        raise(at(c - d, r + h), centre);
      }
    }
  }
}

/// Bit i where the i-th code is above the step.
std::uint64_t bits_above(const std::uint8_t* codes, int count, int step) {
  constexpr std::uint64_t kOnes = 0x0101010101010101u;
  const auto add = static_cast<std::uint64_t>(kMostCode - step) * kOnes;
  std::uint64_t bits = 0;
  for (int i = 0; i < count; i += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, codes + i, sizeof word);
    const std::uint64_t above = (word + add) >> 7 & kOnes;
    bits |= (above * 0x0102040810204080u >> 56) << i;  // gathers the bytes' lowest bits
  }
  return bits;
}

std::uint64_t inner(std::uint64_t bits, int cells) {
  const std::uint64_t below = cells == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << cells) - 1;
  return bits & below & ~std::uint64_t{1};
}

}  // namespace

VertexSteps::VertexSteps(const HeightTile& heights, const TileId& id, double quantum_m, bool between_samples)
    : size_(heights.size) {
  const std::vector<float> errors = vertex_errors_m(heights, id, quantum_m, between_samples);
  codes_.resize(errors.size() + kBeyond);
  std::transform(errors.begin(), errors.end(), codes_.begin(), code_of);
  pass_on_to_needed(codes_, size_, root_rises(id));
  for (int column = 0; column < size_; column += kColumnStep) {
    for (int row = 0; row < size_; ++row) columns_.push_back(row_of(row)[column]);
  }
  columns_.resize(columns_.size() + kBeyond);
}

double VertexSteps::tolerance_m(int step) {
  return tolerances_m()[static_cast<std::size_t>(step)];
}

int VertexSteps::step_within(double allowed_m) {
  const auto& table = tolerances_m();
  // Above the last code nothing is left but the corners of squares.
  return static_cast<int>(std::upper_bound(table.begin(), table.end() - 1, allowed_m) - table.begin()) - 1;
}

std::uint64_t VertexSteps::along_row(int column, int row, int cells, int step) const {
  return inner(bits_above(row_of(row) + column, cells, step), cells);
}

std::uint64_t VertexSteps::along_column(int column, int row, int cells, int step) const {
  if (column % kColumnStep == 0) {
    const std::size_t first =
        static_cast<std::size_t>(column / kColumnStep) * static_cast<std::size_t>(size_);
    return inner(bits_above(&columns_[first + static_cast<std::size_t>(row)], cells, step), cells);
  }
  std::uint64_t bits = 0;
  for (int i = 1; i < cells; ++i) bits |= std::uint64_t{has(column, row + i, step)} << i;
  return bits;
}

}  // namespace cairn
