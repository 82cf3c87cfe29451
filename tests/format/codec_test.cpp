#include "format/codec.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>

#include <catch2/catch.hpp>

#include "tests/support/test_data.h"

namespace {

using cairn::HeightCodec;
using Samples = std::vector<std::int32_t>;

std::size_t area(int size) {
  return static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
}

template <class Height>
Samples make(int size, Height height) {
  Samples samples;
  samples.reserve(area(size));
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column)
      samples.push_back(static_cast<std::int32_t>(height(column, row)));
  }
  return samples;
}

constexpr std::int32_t kLowest = std::numeric_limits<std::int32_t>::min();
constexpr std::int32_t kHighest = std::numeric_limits<std::int32_t>::max();

struct Named {
  std::string name;
  Samples samples;
};

/// Surfaces of every kind that a bake may meet, and some that it should not.
std::vector<Named> generated(int size) {
  std::mt19937 random(static_cast<unsigned>(size));
  const auto any = [&](int, int) { return random(); };
  const auto wave = [](double x, double y) {
    return 900 * std::sin(x * 0.05) * std::cos(y * 0.031) + x * 2.5;
  };
  return {
      {"flat", make(size, [](int, int) { return 7; })},
      {"flat, lowest", make(size, [](int, int) { return kLowest; })},
      {"flat, highest", make(size, [](int, int) { return kHighest; })},
      {"any int32", make(size, any)},
      {"any int16", make(size, [&](int, int) { return static_cast<std::int16_t>(random()); })},
      {"bits", make(size, [&](int, int) { return random() & 1; })},
      {"extremes", make(size, [&](int, int) { return random() % 2 ? kLowest : kHighest; })},
      {"chessboard of extremes", make(size, [](int x, int y) { return (x + y) % 2 ? kLowest : kHighest; })},
      {"ramp", make(size, [](int x, int y) { return 3 * x - 2 * y; })},
      {"steep ramp", make(size, [](int x, int y) { return 100003 * x - 70001 * y; })},
      {"wave", make(size, wave)},
      {"rough wave",
       make(size, [&](int x, int y) { return wave(x, y) + static_cast<double>(random() % 9); })},
      {"coast",
       make(size,
            [&](int x, int y) { return std::max(0.0, wave(x, y)) * static_cast<double>(1 + random() % 3); })},
      {"spike", make(size, [size](int x, int y) { return x == size / 2 && y == size / 2 ? kHighest : 0; })},
      {"one row", make(size, [size](int, int y) { return y == size - 1 ? 40000 : 0; })},
      {"one column", make(size, [size](int x, int) { return x == size - 1 ? -40000 : 0; })},
      {"cliff", make(size, [size](int x, int) { return x < size / 2 ? -20000 : 40000; })},
  };
}

std::vector<std::byte> code_of(const HeightCodec& codec, int size, const Samples& samples) {
  std::vector<std::byte> code;
  codec.encode(samples, size, code);
  return code;
}

void check_round_trip(const HeightCodec& codec, int size, const Samples& samples) {
  const auto code = code_of(codec, size, samples);
  Samples decoded(samples.size(), 123456789);
  const cairn::Status status = codec.decode(code, size, decoded);
  REQUIRE(status.ok());
  REQUIRE(decoded == samples);
  CHECK(code == code_of(codec, size, samples));
}

/// The corner of a plain .hgt file: big-endian int16, rows from north to south.
Samples hgt_tile(const std::filesystem::path& file, int posts, int column, int row, int size) {
  std::ifstream in(file, std::ios::binary);
  Samples samples;
  std::vector<unsigned char> bytes(static_cast<std::size_t>(size) * 2);
  for (int y = row + size - 1; y >= row; --y) {
    in.seekg((static_cast<std::streamoff>(y) * posts + column) * 2);
    in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    REQUIRE(in.good());
    for (std::size_t i = 0; i < bytes.size(); i += 2) {
      samples.push_back(static_cast<std::int16_t>(bytes[i] << 8 | bytes[i + 1]));
    }
  }
  return samples;
}

}  // namespace

TEST_CASE("Height codecs have distinct ids and names and are found by id") {
  for (const HeightCodec* codec : cairn::height_codecs()) {
    CHECK(cairn::find_height_codec(codec->id) == codec);
    for (const HeightCodec* other : cairn::height_codecs()) {
      CHECK((other == codec || std::string(other->name) != codec->name));
    }
  }
  const auto codecs = cairn::height_codecs();
  CHECK(std::count(codecs.begin(), codecs.end(), &cairn::default_height_codec()) == 1);
}

TEST_CASE("Every height codec gives back every surface, at every size") {
  for (const int size : {2, 3, 4, 5, 7, 8, 15, 16, 17, 31, 33, 64, 65, 129, 257, 513}) {
    for (const Named& surface : generated(size)) {
      for (const HeightCodec* codec : cairn::height_codecs()) {
        INFO(codec->name << ", " << surface.name << ", size " << size);
        check_round_trip(*codec, size, surface.samples);
      }
    }
  }
}

TEST_CASE("Every height codec gives back tiles of real 3-second cells", "[data]") {
  const auto data = cairn::test::real_data();
  if (!data) return;
  for (const char* cell : {"N00E010", "N44W072", "N57E011", "N00W177"}) {
    for (const int size : {257, 513}) {
      const Samples tile = hgt_tile(*data / "srtm3" / (std::string(cell) + ".hgt"), 1201, 300, 200, size);
      for (const HeightCodec* codec : cairn::height_codecs()) {
        INFO(codec->name << ", " << cell << ", size " << size);
        check_round_trip(*codec, size, tile);
      }
    }
  }
}

TEST_CASE("Every height codec appends its code and leaves what is before it alone") {
  const Samples samples = generated(17)[10].samples;
  for (const HeightCodec* codec : cairn::height_codecs()) {
    std::vector<std::byte> out(3, std::byte{42});
    codec->encode(samples, 17, out);
    const auto alone = code_of(*codec, 17, samples);
    REQUIRE(out.size() == alone.size() + 3);
    CHECK(std::count(out.begin(), out.begin() + 3, std::byte{42}) == 3);
    CHECK(std::equal(alone.begin(), alone.end(), out.begin() + 3));
  }
}

TEST_CASE("A height code that is cut or has a byte too many is refused") {
  for (const HeightCodec* codec : cairn::height_codecs()) {
    for (const int size : {2, 17, 40}) {
      for (const Named& surface : generated(size)) {
        INFO(codec->name << ", " << surface.name << ", size " << size);
        auto code = code_of(*codec, size, surface.samples);
        Samples decoded(surface.samples.size());
        for (std::size_t length = 0; length < code.size(); ++length) {
          // A copy of its own, so that a sanitizer sees a read past the end.
          const std::vector<std::byte> prefix(code.begin(),
                                              code.begin() + static_cast<std::ptrdiff_t>(length));
          REQUIRE_FALSE(codec->decode(prefix, size, decoded).ok());
        }
        code.push_back(std::byte{0});
        CHECK_FALSE(codec->decode(code, size, decoded).ok());
      }
    }
  }
}

TEST_CASE("A damaged height code gives an error or a tile, and never reads or writes outside") {
  std::mt19937 random(2);
  for (const HeightCodec* codec : cairn::height_codecs()) {
    for (const int size : {2, 17, 65}) {
      for (const Named& surface : generated(size)) {
        const auto code = code_of(*codec, size, surface.samples);
        for (int trial = 0; trial < 200; ++trial) {
          auto damaged = code;
          const std::size_t reach = trial % 2 ? damaged.size() : std::min<std::size_t>(damaged.size(), 64);
          for (int flips = 1 + trial % 3; flips > 0; --flips) {
            damaged[random() % reach] ^= static_cast<std::byte>(1u << random() % 8);
          }
          Samples decoded(surface.samples.size());
          const cairn::Status status = codec->decode(damaged, size, decoded);
          CHECK((status.ok() || status.error().code == cairn::ErrorCode::bad_data));
        }
      }
    }
  }
}

TEST_CASE("Garbage and the code of another size are no height code of this size") {
  std::mt19937 random(3);
  for (const HeightCodec* codec : cairn::height_codecs()) {
    INFO(codec->name);
    Samples decoded(area(33));
    for (int trial = 0; trial < 2000; ++trial) {
      std::vector<std::byte> garbage(random() % 300);
      for (std::byte& byte : garbage) byte = static_cast<std::byte>(random());
      const cairn::Status status = codec->decode(garbage, 33, decoded);
      CHECK((status.ok() || status.error().code == cairn::ErrorCode::bad_data));
    }
    for (const int size : {32, 34}) {
      const auto code = code_of(*codec, size, generated(size)[11].samples);
      CHECK_FALSE(codec->decode(code, 33, decoded).ok());
    }
  }
}

TEST_CASE("Height codecs read the bytes of before, and the default codec writes them") {
  // Integers only, so that no library's sine decides.
  const auto relief = [](int x, int y) {
    const int hill = (x - 30) * (x - 30) / 5 - (y - 41) * (y - 41) / 7 + x * y % 13;
    return hill + (x * 7919 + y * 104729) % 97 / 31 + (x == 17 && y == 23 ? 9000 : 0);
  };
  const Samples samples = make(65, relief);
  for (const HeightCodec* codec : cairn::height_codecs()) {
    INFO(codec->name << ": set CAIRN_UPDATE_GOLDEN=1 to accept new bytes, and say so in the changelog");
    const auto file = cairn::test::sample_dem().parent_path() / "tests" / "golden" /
                      (std::string("height_") + codec->name + ".bin");
    const auto code = code_of(*codec, 65, samples);
    if (std::getenv("CAIRN_UPDATE_GOLDEN") != nullptr) {
      std::filesystem::create_directories(file.parent_path());
      std::ofstream(file, std::ios::binary)
          .write(reinterpret_cast<const char*>(code.data()), static_cast<std::streamsize>(code.size()));
    }
    std::ifstream in(file, std::ios::binary);
    const std::string golden{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    const auto bytes = std::as_bytes(std::span(golden));
    Samples decoded(samples.size());
    CHECK(codec->decode(bytes, 65, decoded).ok());
    CHECK(decoded == samples);
    // The others' bytes are zstd's, which change with its version.
    if (codec == &cairn::default_height_codec()) {
      CHECK(std::equal(bytes.begin(), bytes.end(), code.begin(), code.end()));
    }
  }
}
