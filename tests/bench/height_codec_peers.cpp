#include "tests/bench/height_codec_peers.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>

#include <zstd.h>
#ifdef CAIRN_CHARLS
#include <charls/charls.h>
#endif
#ifdef CAIRN_OPENJPEG
#include <openjpeg.h>
#endif

namespace cairn::bench {
namespace {

using Bytes = std::vector<std::byte>;

/// The samples less the lowest, which goes in front of the code.
std::vector<std::uint16_t> lowered(std::span<const std::int32_t> samples, Bytes& out) {
  const std::int32_t low = *std::min_element(samples.begin(), samples.end());
  const auto bytes = std::as_bytes(std::span(&low, 1));
  out.insert(out.end(), bytes.begin(), bytes.end());
  std::vector<std::uint16_t> result(samples.size());
  std::transform(samples.begin(), samples.end(), result.begin(),
                 [&](std::int32_t s) { return static_cast<std::uint16_t>(s - low); });
  return result;
}

std::int32_t lowest(std::span<const std::byte> code) {
  std::int32_t low;
  std::memcpy(&low, code.data(), sizeof low);
  return low;
}

void raise(std::span<const std::uint16_t> from, std::int32_t low, std::span<std::int32_t> to) {
  std::transform(from.begin(), from.end(), to.begin(), [&](std::uint16_t s) { return s + low; });
}

int bits_of(std::span<const std::uint16_t> samples) {
  return std::max(2, static_cast<int>(std::bit_width(*std::max_element(samples.begin(), samples.end()))));
}

Coder differences_zstd(int level) {
  Coder coder;
  coder.name = "differences, zstd-" + std::to_string(level);
  coder.encode = [level](std::span<const std::int32_t> samples, int size, Bytes& out) {
    auto values = lowered(samples, out);
    const auto width = static_cast<std::size_t>(size);
    for (std::size_t i = values.size(); i-- > 0;) {
      if (i % width != 0) values[i] = static_cast<std::uint16_t>(values[i] - values[i - 1]);
    }
    const std::size_t start = out.size();
    out.resize(start + ZSTD_compressBound(2 * values.size()));
    const std::size_t used =
        ZSTD_compress(out.data() + start, out.size() - start, values.data(), 2 * values.size(), level);
    out.resize(start + used);
  };
  coder.decode = [](std::span<const std::byte> code, int size, std::span<std::int32_t> samples) {
    std::vector<std::uint16_t> values(samples.size());
    const std::size_t got =
        ZSTD_decompress(values.data(), 2 * values.size(), code.data() + 4, code.size() - 4);
    const auto width = static_cast<std::size_t>(size);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (i % width != 0) values[i] = static_cast<std::uint16_t>(values[i] + values[i - 1]);
    }
    raise(values, lowest(code), samples);
    return got == 2 * values.size();
  };
  return coder;
}

#ifdef CAIRN_CHARLS
Coder jpeg_ls() {
  Coder coder;
  coder.name = "JPEG-LS (CharLS)";
  coder.encode = [](std::span<const std::int32_t> samples, int size, Bytes& out) {
    const auto values = lowered(samples, out);
    charls::jpegls_encoder encoder;
    encoder.frame_info(
        {static_cast<std::uint32_t>(size), static_cast<std::uint32_t>(size), bits_of(values), 1});
    Bytes code(encoder.estimated_destination_size());
    encoder.destination(code);
    // Up to eight bits, CharLS takes bytes.
    const std::vector<std::uint8_t> narrow(values.begin(), values.end());
    code.resize(bits_of(values) <= 8 ? encoder.encode(narrow) : encoder.encode(values));
    out.insert(out.end(), code.begin(), code.end());
  };
  coder.decode = [](std::span<const std::byte> code, int, std::span<std::int32_t> samples) {
    charls::jpegls_decoder decoder;
    decoder.source(code.data() + 4, code.size() - 4).read_header();
    std::vector<std::uint16_t> values(samples.size());
    if (decoder.frame_info().bits_per_sample <= 8) {
      std::vector<std::uint8_t> narrow(samples.size());
      decoder.decode(narrow);
      std::copy(narrow.begin(), narrow.end(), values.begin());
    } else {
      decoder.decode(values);
    }
    raise(values, lowest(code), samples);
    return true;
  };
  return coder;
}
#endif

#ifdef CAIRN_OPENJPEG
struct Memory {
  Bytes bytes;
  std::size_t at = 0;
};

OPJ_SIZE_T read_memory(void* to, OPJ_SIZE_T count, void* user) {
  auto& memory = *static_cast<Memory*>(user);
  const std::size_t given = std::min(count, memory.bytes.size() - memory.at);
  if (given == 0) return static_cast<OPJ_SIZE_T>(-1);
  std::memcpy(to, memory.bytes.data() + memory.at, given);
  memory.at += given;
  return given;
}

OPJ_SIZE_T write_memory(void* from, OPJ_SIZE_T count, void* user) {
  auto& memory = *static_cast<Memory*>(user);
  if (memory.bytes.size() < memory.at + count) memory.bytes.resize(memory.at + count);
  std::memcpy(memory.bytes.data() + memory.at, from, count);
  memory.at += count;
  return count;
}

OPJ_BOOL seek_memory(OPJ_OFF_T to, void* user) {
  static_cast<Memory*>(user)->at = static_cast<std::size_t>(to);
  return OPJ_TRUE;
}

OPJ_OFF_T skip_memory(OPJ_OFF_T count, void* user) {
  static_cast<Memory*>(user)->at += static_cast<std::size_t>(count);
  return count;
}

using Stream = std::unique_ptr<opj_stream_t, decltype(&opj_stream_destroy)>;
using Codec = std::unique_ptr<opj_codec_t, decltype(&opj_destroy_codec)>;
using Image = std::unique_ptr<opj_image_t, decltype(&opj_image_destroy)>;

Stream stream_over(Memory& memory, bool input) {
  Stream stream(opj_stream_create(OPJ_J2K_STREAM_CHUNK_SIZE, input), opj_stream_destroy);
  opj_stream_set_read_function(stream.get(), read_memory);
  opj_stream_set_write_function(stream.get(), write_memory);
  opj_stream_set_seek_function(stream.get(), seek_memory);
  opj_stream_set_skip_function(stream.get(), skip_memory);
  opj_stream_set_user_data(stream.get(), &memory, nullptr);
  opj_stream_set_user_data_length(stream.get(), memory.bytes.size());
  return stream;
}

void encode_jpeg_2000(std::span<const std::int32_t> samples, int size, Bytes& out) {
  const auto values = lowered(samples, out);
  opj_cparameters_t parameters;
  opj_set_default_encoder_parameters(&parameters);
  parameters.tcp_numlayers = 1;
  parameters.cp_disto_alloc = 1;
  opj_image_cmptparm_t component{};
  component.dx = component.dy = 1;
  component.w = component.h = static_cast<OPJ_UINT32>(size);
  component.prec = static_cast<OPJ_UINT32>(bits_of(values));
  const Image image(opj_image_create(1, &component, OPJ_CLRSPC_GRAY), opj_image_destroy);
  image->x1 = image->y1 = static_cast<OPJ_UINT32>(size);
  std::copy(values.begin(), values.end(), image->comps[0].data);
  const Codec codec(opj_create_compress(OPJ_CODEC_J2K), opj_destroy_codec);
  opj_setup_encoder(codec.get(), &parameters, image.get());
  Memory memory;
  const Stream stream = stream_over(memory, false);
  if (opj_start_compress(codec.get(), image.get(), stream.get()) && opj_encode(codec.get(), stream.get())) {
    opj_end_compress(codec.get(), stream.get());
  }
  out.insert(out.end(), memory.bytes.begin(), memory.bytes.end());
}

bool decode_jpeg_2000(std::span<const std::byte> code, int, std::span<std::int32_t> samples) {
  Memory memory{Bytes(code.begin() + 4, code.end()), 0};
  const Stream stream = stream_over(memory, true);
  const Codec codec(opj_create_decompress(OPJ_CODEC_J2K), opj_destroy_codec);
  opj_dparameters_t parameters;
  opj_set_default_decoder_parameters(&parameters);
  opj_setup_decoder(codec.get(), &parameters);
  opj_image_t* found = nullptr;
  if (!opj_read_header(stream.get(), codec.get(), &found)) return false;
  const Image image(found, opj_image_destroy);
  if (!opj_decode(codec.get(), stream.get(), image.get())) return false;
  const std::int32_t low = lowest(code);
  std::transform(image->comps[0].data, image->comps[0].data + samples.size(), samples.begin(),
                 [&](OPJ_INT32 s) { return s + low; });
  return true;
}
#endif

}  // namespace

std::vector<Coder> peers() {
  std::vector<Coder> result = {differences_zstd(1), differences_zstd(9)};
#ifdef CAIRN_CHARLS
  result.push_back(jpeg_ls());
#endif
#ifdef CAIRN_OPENJPEG
  result.push_back({"JPEG 2000 (OpenJPEG)", encode_jpeg_2000, decode_jpeg_2000});
#endif
  return result;
}

}  // namespace cairn::bench
