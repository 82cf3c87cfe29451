#include "builder/imagery/edge_texels.h"

#include <algorithm>

namespace cairn {
namespace {

template <class Pair>
Pair mean_of_pairs(const Pair& a, const Pair& b) {
  return {mean_of(a.inside, b.inside), mean_of(a.outside, b.outside)};
}

template <class Line>
Line halved_line(const Line& line) {
  Line half;
  half.reserve(line.size() / 2);
  for (std::size_t i = 0; i + 1 < line.size(); i += 2) half.push_back(mean_of_pairs(line[i], line[i + 1]));
  return half;
}

void write_texel(ByteWriter& writer, const LinearTexel& texel) {
  for (const std::uint16_t value : texel) writer.write(value);
}

LinearTexel read_texel(ByteReader& in) {
  LinearTexel texel;
  for (std::uint16_t& value : texel) value = in.read<std::uint16_t>();
  return texel;
}

}  // namespace

EdgeTexels EdgeTexels::cut(const LinearImage& padded, const LinearImage& half) {
  EdgeTexels rim;
  rim.lines_.resize(4);
  rim.corners_.resize(4);
  LinearImage smaller;
  for (int margin = kRim; margin >= 1; margin /= 2) {
    const LinearImage& image = margin == kRim ? padded : margin == kRim / 2 ? half : smaller;
    const int size = image.columns - 2 * margin, last = margin + size - 1;
    const auto at = [&](int c, int r) { return image.row(r)[c]; };
    std::array<std::vector<Pair>, 4> line;
    for (auto& side : line) side.reserve(static_cast<std::size_t>(size));
    for (int i = margin; i <= last; ++i) {
      line[north].push_back({at(i, margin), at(i, margin - 1)});
      line[south].push_back({at(i, last), at(i, last + 1)});
      line[west].push_back({at(margin, i), at(margin - 1, i)});
      line[east].push_back({at(last, i), at(last + 1, i)});
    }
    for (std::size_t s = 0; s < 4; ++s) rim.lines_[s].push_back(std::move(line[s]));
    for (std::size_t q = 0; q < 4; ++q) {
      const int c = q & 1 ? last : margin, r = q & 2 ? margin : last;
      const int beside = q & 1 ? c + 1 : c - 1, beyond = q & 2 ? r - 1 : r + 1;
      rim.corners_[q].push_back({at(c, r), at(beside, r), at(c, beyond), at(beside, beyond)});
    }
    if (margin > 1 && margin < kRim) smaller = halved(image);
  }
  for (Mips& mips : rim.lines_) {
    while (mips.back().size() > 1) mips.push_back(halved_line(mips.back()));
  }
  return rim;
}

EdgeTexels EdgeTexels::join(const std::array<const EdgeTexels*, 4>& children, int size) {
  constexpr std::array<std::array<std::size_t, 2>, 4> kAlong = {{{2, 3}, {3, 1}, {0, 1}, {2, 0}}};
  EdgeTexels rim;
  rim.lines_.resize(4);
  rim.corners_.resize(4);
  for (std::size_t s = 0; s < 4; ++s) {
    for (std::size_t mip = 0; size >> (mip + 1) > 0; ++mip) {
      std::vector<Pair> line;
      line.reserve(static_cast<std::size_t>(size >> mip));
      for (const std::size_t q : kAlong[s]) {
        const bool there = children[q] != nullptr && !children[q]->is_empty();
        const std::vector<Pair> half = there ? children[q]->lines_[s][mip + 1]
                                             : std::vector<Pair>(static_cast<std::size_t>(size >> (mip + 1)));
        line.insert(line.end(), half.begin(), half.end());
      }
      rim.lines_[s].push_back(std::move(line));
    }
    rim.lines_[s].push_back(halved_line(rim.lines_[s].back()));
  }
  for (std::size_t q = 0; q < 4; ++q) {
    if (children[q] == nullptr || children[q]->is_empty()) {
      rim.corners_[q].resize(1);
      continue;
    }
    const auto& own = children[q]->corners_[q];
    rim.corners_[q].assign(own.size() > 1 ? own.begin() + 1 : own.begin(), own.end());
  }
  return rim;
}

void EdgeTexels::agree(int mip, LinearImage& image) const {
  const int size = image.columns;
  if (is_empty() || size < 2) return;
  const auto meet = [](const Pair& pair, LinearTexel& texel) {
    if (pair.inside[3] != 0 && pair.outside[3] != 0) texel = mean_of(pair.inside, pair.outside);
  };
  const auto at = static_cast<std::size_t>(mip);
  for (int i = 1; i < size - 1; ++i) {
    const auto n = static_cast<std::size_t>(i);
    meet(lines_[north][at][n], image.row(0)[i]);
    meet(lines_[south][at][n], image.row(size - 1)[i]);
    meet(lines_[west][at][n], image.row(i)[0]);
    meet(lines_[east][at][n], image.row(i)[size - 1]);
  }
  for (std::size_t q = 0; q < 4; ++q) {
    const Corner& corner = corners_[q][std::min(at, corners_[q].size() - 1)];
    if (corner[0][3] == 0) continue;
    std::array<std::uint32_t, 4> sum{};
    std::uint32_t count = 0;
    for (const LinearTexel& texel : corner) {
      if (texel[3] == 0) continue;
      for (std::size_t k = 0; k < 4; ++k) sum[k] += texel[k];
      ++count;
    }
    LinearTexel& texel = image.row(q & 2 ? 0 : size - 1)[q & 1 ? size - 1 : 0];
    for (std::size_t k = 0; k < 4; ++k) texel[k] = static_cast<std::uint16_t>((sum[k] + count / 2) / count);
  }
}

void EdgeTexels::append_to(std::vector<std::byte>& out) const {
  ByteWriter writer(out);
  for (const Mips& mips : lines_) {
    for (const auto& line : mips) {
      for (const Pair& pair : line) {
        write_texel(writer, pair.inside);
        write_texel(writer, pair.outside);
      }
    }
  }
  for (const auto& corners : corners_) {
    writer.write(static_cast<std::uint8_t>(corners.size()));
    for (const Corner& corner : corners)
      for (const LinearTexel& texel : corner) write_texel(writer, texel);
  }
}

EdgeTexels EdgeTexels::read_from(ByteReader& in, int size) {
  EdgeTexels rim;
  rim.lines_.resize(4);
  rim.corners_.resize(4);
  for (Mips& mips : rim.lines_) {
    for (int side = size; side > 0; side /= 2) {
      auto& line = mips.emplace_back(static_cast<std::size_t>(side));
      for (Pair& pair : line) {
        pair.inside = read_texel(in);
        pair.outside = read_texel(in);
      }
    }
  }
  for (auto& corners : rim.corners_) {
    corners.resize(std::max<std::size_t>(1, in.read<std::uint8_t>()));
    for (Corner& corner : corners)
      for (LinearTexel& texel : corner) texel = read_texel(in);
  }
  return rim;
}

}  // namespace cairn
