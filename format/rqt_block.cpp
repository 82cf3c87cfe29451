#include "format/rqt_block.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <string>

#include "format/bytes.h"
#include "format/zstd_frame.h"

namespace cairn {
namespace {

constexpr std::uint8_t kPlain = 0;
constexpr std::uint8_t kZstd = 1;
constexpr int kZstdLevel = 9;  // the level decides bytes, so it never changes
constexpr std::size_t kHeadBytes = 12;

std::size_t bytes_for(std::size_t bits) {
  return (bits + 7) / 8;
}

class BitWriter {
 public:
  void write(bool bit) {
    if (count_ % 8 == 0) bytes_.push_back(std::byte{0});
    if (bit) bytes_.back() |= std::byte{1} << (count_ % 8);
    ++count_;
  }
  std::size_t count() const { return count_; }
  const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
  std::size_t count_ = 0;
};

class BitReader {
 public:
  BitReader(std::span<const std::byte> bytes, std::size_t count) : bytes_(bytes), count_(count) {}

  /// 0 past the end; ok() tells.
  bool read() {
    const std::size_t i = at_++;
    return i < count_ && ((bytes_[i / 8] >> (i % 8)) & std::byte{1}) != std::byte{0};
  }
  std::size_t position() const { return at_; }
  bool spare_bits_are_zero() const {
    return count_ % 8 == 0 || (bytes_[count_ / 8] >> (count_ % 8)) == std::byte{0};
  }

 private:
  std::span<const std::byte> bytes_;
  std::size_t count_;
  std::size_t at_ = 0;
};

Status read_vertices(BitReader& bits, std::size_t count, RqtBlock& block) {
  RqtSteps& vertices = block.vertices;
  const auto steps = vertices.writable();
  for (int k = 0; k < block.steps && bits.position() <= count; ++k) {
    for_each_rqt_vertex(vertices.size(), vertices.rising(), [&](std::size_t i, const RqtNeeds& needs) {
      if (steps[i] == k && steps[needs.first] > k && steps[needs.second] > k && bits.read())
        steps[i] = static_cast<std::uint8_t>(k + 1);
    });
  }
  if (bits.position() == count && bits.spare_bits_are_zero()) return {};
  return bad_data("rqt block: expected " + std::to_string(count) + " bits of flags, found flags that take " +
                  (bits.position() == count ? "others after them" : std::to_string(bits.position())));
}

}  // namespace

std::vector<std::byte> encode_rqt_block(const RqtBlock& block) {
  assert(block.steps >= 1 && block.steps <= kMostRqtSteps);
  const RqtSteps& vertices = block.vertices;
  const auto steps = vertices.all();
  BitWriter bits;
  for (int k = 0; k < block.steps; ++k) {
    for_each_rqt_vertex(vertices.size(), vertices.rising(), [&](std::size_t i, const RqtNeeds& needs) {
      if (steps[i] >= k && steps[needs.first] > k && steps[needs.second] > k) bits.write(steps[i] > k);
    });
  }
  std::vector<std::byte> frame;
  append_zstd_frame(bits.bytes(), {.level = kZstdLevel}, frame);
  const bool shorter = frame.size() < bits.bytes().size();
  std::vector<std::byte> out;
  ByteWriter writer(out);
  writer.write(shorter ? kZstd : kPlain);
  writer.write(static_cast<std::uint8_t>(block.steps));
  writer.write(std::uint16_t{0});
  writer.write(block.tolerance_m);
  writer.write(static_cast<std::uint32_t>(bits.count()));
  writer.append(shorter ? frame : bits.bytes());
  return out;
}

Result<RqtBlock> decode_rqt_block(std::span<const std::byte> bytes, int tile_size, bool rising) {
  ByteReader in(bytes);
  const auto code = in.read<std::uint8_t>();
  const auto steps = in.read<std::uint8_t>();
  const auto reserved = in.read<std::uint16_t>();
  RqtBlock block{in.read<float>(), steps, RqtSteps(tile_size, rising)};
  const auto count = static_cast<std::size_t>(in.read<std::uint32_t>());
  if (!in.ok())
    return bad_data("rqt block: expected 12 bytes or more, found " + std::to_string(bytes.size()));
  if (code > kZstd || reserved != 0 || steps < 1 || steps > kMostRqtSteps)
    return bad_data("rqt block: expected code 0 or 1, 1 to 16 steps and reserved 0, found others");
  if (!std::isfinite(block.tolerance_m) || block.tolerance_m <= 0)
    return bad_data("rqt block: tolerance: expected metres above 0, found " +
                    std::to_string(block.tolerance_m));
  // A vertex is visited once more than it has steps, at most.
  if (count > block.vertices.all().size() * (static_cast<std::size_t>(steps) + 1))
    return bad_data("rqt block: expected flags of one tile, found " + std::to_string(count));
  std::span<const std::byte> flags = in.take(in.remaining());
  std::vector<std::byte> plain;
  if (code == kZstd) {
    plain.resize(bytes_for(count));
    if (auto status = decode_zstd_frame(flags, plain); !status)
      return bad_data("rqt block: " + status.error().message);
    flags = plain;
  }
  if (flags.size() != bytes_for(count))
    return bad_data("rqt block: expected " + std::to_string(bytes_for(count)) + " bytes of flags, found " +
                    std::to_string(flags.size()));
  BitReader bits(flags, count);
  if (auto status = read_vertices(bits, count, block); !status) return status.error();
  return block;
}

std::size_t rqt_bit_count(std::span<const std::byte> bytes) {
  ByteReader in(bytes.subspan(kHeadBytes - sizeof(std::uint32_t)));
  return in.read<std::uint32_t>();
}

}  // namespace cairn
