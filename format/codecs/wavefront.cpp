// Weighted prediction from twelve neighbours, fitted to the tile; residuals in eight contexts by the activity
// around; thirty-two interleaved coders, one a lane of a skewed wavefront, so that AVX2 decodes thirty-two
// samples a step. docs/height-codec.md explains it and has the byte table.
//
// Code: u8 form, then for a constant tile i32, its value; for a narrow one i32 base, u32 header bytes, u32
// words, u32 escapes, header (the model and row 0, in bits), words, states, escapes; for the rest the
// code of `planes`: tiles whose range does not fit 16 bits, and nearly flat ones.

#include <algorithm>
#include <limits>

#include "format/bytes.h"
#include "format/codec.h"
#include "format/wavefront/bit_stream.h"
#include "format/wavefront/coder.h"
#include "format/wavefront/contexts.h"
#include "format/wavefront/fit.h"

namespace cairn {

extern const HeightCodec planes_codec;

namespace {

using namespace wavefront;

enum class Form : std::uint8_t { constant = 0, narrow = 1, planes = 2 };

// --- Row 0: differences of first or second order, Rice-coded. ---

std::vector<std::uint16_t> differences(std::span<const std::int16_t> row, int order) {
  std::vector<std::uint16_t> result(row.size());
  std::int32_t last = 0;
  std::int32_t slope = 0;
  for (std::size_t i = 0; i < row.size(); ++i) {
    result[i] = zigzag(static_cast<std::int16_t>(row[i] - last - slope));
    slope = order == 2 && i > 0 ? row[i] - last : 0;
    last = row[i];
  }
  return result;
}

struct RowCode {
  int order = 1;
  unsigned rice_bits = 0;
  std::vector<std::uint16_t> values;
  std::uint64_t bits = std::numeric_limits<std::uint64_t>::max();
};

RowCode best_row_code(std::span<const std::int16_t> row) {
  RowCode best;
  for (const int order : {1, 2}) {
    const auto values = differences(row, order);
    for (unsigned rice_bits = 0; rice_bits < 16; ++rice_bits) {
      std::uint64_t bits = 0;
      for (const std::uint16_t v : values) bits += rice_length(v, rice_bits);
      if (bits < best.bits) best = {order, rice_bits, values, bits};
    }
  }
  return best;
}

void write_first_row(std::span<const std::int16_t> row, BitWriter& out) {
  const RowCode code = best_row_code(row);
  out.write(code.order == 2, 1);
  out.write(code.rice_bits, 4);
  for (const std::uint16_t value : code.values) out.write_rice(value, code.rice_bits);
}

bool read_first_row(BitReader& in, std::int32_t base, std::span<std::int32_t> row) {
  const bool second_order = in.read(1) != 0;
  const unsigned rice_bits = in.read(4);
  std::int32_t last = 0;
  std::int32_t slope = 0;
  for (std::size_t i = 0; i < row.size(); ++i) {
    const auto sample = static_cast<std::int16_t>(last + slope + unzigzag(in.read_rice(rice_bits)));
    row[i] = from_base(sample, base);
    slope = second_order && i > 0 ? sample - last : 0;
    last = sample;
  }
  return in.ok();
}

// --- Encoding ---

bool is_narrow(const Range& range) {
  return std::int64_t{range.high} - range.low <= 65535;
}

/// The value that becomes 0, so that the others fit 16 bits.
std::int32_t base_of(const Range& range) {
  return static_cast<std::int32_t>(range.low + ((std::int64_t{range.high} - range.low + 1) / 2));
}

void write_narrow(std::int32_t base, std::span<const std::byte> bits, const Streams& streams,
                  std::vector<std::byte>& out) {
  ByteWriter writer(out);
  writer.write(static_cast<std::uint8_t>(Form::narrow));
  writer.write(base);
  writer.write(static_cast<std::uint32_t>(bits.size()));
  writer.write(static_cast<std::uint32_t>(streams.words.size()));
  writer.write(static_cast<std::uint32_t>(streams.escapes.size()));
  writer.append(bits);
  writer.append(std::as_bytes(std::span(streams.words)));
  writer.append(std::as_bytes(std::span(streams.states)));
  writer.append(std::as_bytes(std::span(streams.escapes)));
}

void encode_narrow(std::span<const std::int32_t> samples, int size, std::int32_t base,
                   std::vector<std::byte>& out) {
  const Geometry g(size);
  const Plane plane = make_plane(g, samples, base);
  Model model;
  model.weights = fit_weights(g, plane);
  Histogram histogram;
  const Residuals residuals = find_residuals(g, plane, model.weights, histogram);
  choose_contexts(histogram, model);
  const Streams streams = encode_samples(g, model, residuals);
  std::vector<std::byte> bits;
  BitWriter bit_writer(bits);
  write_model(model, bit_writer);
  write_first_row({plane.data() + g.row_start(0) + kLeft, static_cast<std::size_t>(size)}, bit_writer);
  bit_writer.finish();
  write_narrow(base, bits, streams, out);
}

void encode_planes(std::span<const std::int32_t> samples, int size, std::vector<std::byte>& out) {
  out.push_back(static_cast<std::byte>(Form::planes));
  planes_codec.encode(samples, size, out);
}

/// On nearly flat tiles the model and the coders' states weigh more than the samples.
void encode_smallest(std::span<const std::int32_t> samples, int size, std::int32_t base,
                     std::vector<std::byte>& out) {
  const std::size_t start = out.size();
  encode_narrow(samples, size, base, out);
  if ((out.size() - start) * 32 > samples.size()) return;
  std::vector<std::byte> other;
  encode_planes(samples, size, other);
  if (other.size() >= out.size() - start) return;
  out.resize(start);
  out.insert(out.end(), other.begin(), other.end());
}

void encode(std::span<const std::int32_t> samples, int size, std::vector<std::byte>& out) {
  const Range range = range_of(samples);
  if (range.low == range.high) {
    ByteWriter writer(out);
    writer.write(static_cast<std::uint8_t>(Form::constant));
    writer.write(range.low);
  } else if (is_narrow(range)) {
    encode_smallest(samples, size, base_of(range), out);
  } else {
    encode_planes(samples, size, out);
  }
}

// --- Decoding ---

Error damaged(const char* what) {
  return bad_data(std::string("wavefront height code: ") + what);
}

Status decode_constant(ByteReader& in, std::span<std::int32_t> samples) {
  const auto value = in.read<std::int32_t>();
  if (!in.ok() || in.remaining() != 0) return damaged("expected 5 bytes for a constant tile");
  std::fill(samples.begin(), samples.end(), value);
  return {};
}

Status decode_narrow(ByteReader& in, int size, std::span<std::int32_t> samples) {
  const auto base = in.read<std::int32_t>();
  const auto bit_bytes = in.read<std::uint32_t>();
  const std::uint64_t word_count = in.read<std::uint32_t>();
  const std::uint64_t escape_count = in.read<std::uint32_t>();
  const auto bits = in.take(bit_bytes);
  const auto words = in.take(2 * word_count);
  const auto states = in.take(sizeof(CodedSamples::states));
  const auto escapes = in.take(2 * escape_count);
  if (!in.ok() || in.remaining() != 0) return damaged("its parts do not add up to its length");

  const Geometry g(size);
  Model model;
  BitReader reader(bits);
  if (!read_model(reader, model)) return damaged("no valid model");
  if (!read_first_row(reader, base, samples.first(static_cast<std::size_t>(size))) || !reader.finished()) {
    return damaged("no valid first row");
  }

  CodedSamples coded{{}, words.data(), words.size() / 2, escapes.data(), escapes.size() / 2};
  std::memcpy(coded.states.data(), states.data(), states.size());
  for (const std::uint32_t state : coded.states) {
    if (state < kStateFloor || state >> kStateBits != 0) return damaged("a coder's state is out of range");
  }
  if (!decode_samples(g, model, coded, base, samples))
    return damaged("the coders do not end where they began");
  return {};
}

Status decode(std::span<const std::byte> code, int size, std::span<std::int32_t> samples) {
  ByteReader in(code);
  const auto form = static_cast<Form>(in.read<std::uint8_t>());
  if (!in.ok()) return damaged("no bytes");
  switch (form) {
    case Form::constant:
      return decode_constant(in, samples);
    case Form::narrow:
      return decode_narrow(in, size, samples);
    case Form::planes:
      return planes_codec.decode(code.subspan(1), size, samples);
  }
  return damaged("its first byte is no form");
}

}  // namespace

extern const HeightCodec wavefront_codec{2, "wavefront", encode, decode};

}  // namespace cairn
