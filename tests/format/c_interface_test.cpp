#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include <catch2/catch.hpp>

#include "cairn/cairn.h"
#include "cairn/pack_sampler.h"
#include "cairn/texture_tile.h"
#include "format/block_texture.h"
#include "format/pack_writer.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

/// A pack of hills around 28.5°E 37°N with one void sample, and its handle.
class OpenPack {
 public:
  OpenPack() : path_(dir_.path() / "hills.cairn") {
    test::TestSurface surface;
    surface.height = test::hills;
    surface.is_void = [](std::int64_t column, std::int64_t row) { return column % 97 == 5 && row % 89 == 7; };
    test::write_test_pack(path_, surface, test::with_ancestors({tile_at({28.5, 37}, 2)}, 0));
    REQUIRE(cairn_open(path_.c_str(), &pack_, &error_) == CAIRN_OK);
  }
  ~OpenPack() { cairn_close(pack_); }
  OpenPack(const OpenPack&) = delete;
  OpenPack& operator=(const OpenPack&) = delete;

  const std::filesystem::path& path() const { return path_; }
  const cairn_pack* get() const { return pack_; }

 private:
  test::TempDir dir_;
  std::filesystem::path path_;
  cairn_pack* pack_ = nullptr;
  cairn_error error_{};
};

bool is_equal(double a, double b) {
  return a == b || (std::isnan(a) && std::isnan(b));
}

TEST_CASE("C: heights at places are PackSampler's, from several threads at once") {
  const OpenPack pack;
  std::vector<double> lon, lat;
  for (int i = 0; i < 4000; ++i) {
    lon.push_back(28.4 + 0.0001 * i);
    lat.push_back(36.9 + 0.00007 * (i * 37 % 4000));
  }
  lon.push_back(NAN);
  lat.push_back(37);
  const auto reader = PackReader::open(pack.path());
  REQUIRE(reader.ok());
  PackSampler sampler(*reader);
  std::vector<double> expected;
  for (std::size_t i = 0; i + 1 < lon.size(); ++i) {
    const auto height = sampler.height_at({lon[i], lat[i]});
    REQUIRE(height.ok());
    expected.push_back(*height ? (*height)->metres : NAN);
  }
  expected.push_back(NAN);

  std::vector<std::vector<double>> found(3, std::vector<double>(lon.size(), 1e9));
  std::vector<cairn_result> results(3, CAIRN_FAILED);
  {
    std::vector<std::jthread> threads;
    for (std::size_t t = 0; t < 3; ++t) {
      threads.emplace_back([&, t] {
        results[t] =
            cairn_sample_heights(pack.get(), lon.size(), lon.data(), lat.data(), found[t].data(), nullptr);
      });
    }
  }
  for (std::size_t t = 0; t < 3; ++t) {
    REQUIRE(results[t] == CAIRN_OK);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < lon.size(); ++i) wrong += !is_equal(found[t][i], expected[i]);
    CHECK(wrong == 0);
  }
}

TEST_CASE("C: a height tile is the reader's in metres, void samples NaN") {
  const OpenPack pack;
  const auto reader = PackReader::open(pack.path());
  REQUIRE(reader.ok());
  REQUIRE(cairn_tile_size(pack.get()) == 257);
  const TileId id = tile_at({28.5, 37}, 2);
  std::vector<float> metres(257 * 257);
  cairn_error error{};
  REQUIRE(cairn_read_heights(pack.get(), id.level, id.x, id.y, metres.data(), metres.size(), &error) ==
          CAIRN_OK);
  CHECK(std::string(error.text).empty());
  const auto tile = reader->read_height_tile(*reader->find(Layer::heights, id));
  REQUIRE(tile.ok());
  std::size_t voids = 0, wrong = 0;
  for (int row = 0; row < 257; ++row) {
    for (int column = 0; column < 257; ++column) {
      const float height = metres[static_cast<std::size_t>(row * 257 + column)];
      voids += std::isnan(height);
      wrong +=
          !is_equal(height, tile->is_void(column, row)
                                ? NAN
                                : static_cast<float>(tile->at(column, row) * reader->header().quantum_m));
    }
  }
  CHECK(wrong == 0);
  CHECK(voids > 0);
}

TEST_CASE("C: an imagery tile becomes RGBA, constant or not") {
  const test::TempDir dir;
  const auto path = dir.path() / "imagery.cairn";
  TextureTile tile{TextureFormat::bc1, 256, {}};
  tile.texels.resize(texture_chain_bytes(tile.format, tile.size));
  for (std::size_t i = 0; i < tile.texels.size(); ++i) tile.texels[i] = static_cast<std::byte>(i * 31 % 251);
  const PackHeader header = test::test_header();
  {
    auto writer = PackWriter::create(path, header);
    REQUIRE(writer.ok());
    IndexEntry entry;
    entry.layer = Layer::imagery;
    entry.id = {0, 208, 127};
    REQUIRE(writer->add(entry, encode_texture_block(tile)).ok());
    entry.id = {0, 209, 127};
    entry.flags = kConstant;
    entry.min_quanta = entry.max_quanta = static_cast<std::int32_t>(0xFF302010u);
    REQUIRE(writer->add(entry, {}).ok());
    REQUIRE(writer->finish(test::test_metadata(header, writer->levels())).ok());
  }
  cairn_pack* pack = nullptr;
  cairn_error error{};
  REQUIRE(cairn_open(path.c_str(), &pack, &error) == CAIRN_OK);
  std::vector<std::uint8_t> rgba(256 * 256 * 4), expected(rgba.size());
  REQUIRE(cairn_read_imagery(pack, 0, 208, 127, rgba.data(), rgba.size(), &error) == CAIRN_OK);
  REQUIRE(decode_texture(tile.format, std::span(tile.texels).first(256 * 256 / 2), 256, 256, expected).ok());
  CHECK(rgba == expected);
  REQUIRE(cairn_read_imagery(pack, 0, 209, 127, rgba.data(), rgba.size(), &error) == CAIRN_OK);
  CHECK(std::vector<std::uint8_t>(rgba.end() - 4, rgba.end()) == std::vector<std::uint8_t>{16, 32, 48, 255});
  CHECK(cairn_read_imagery(pack, 0, 210, 127, rgba.data(), rgba.size(), &error) == CAIRN_ABSENT);
  CHECK(cairn_read_imagery(pack, 0, 208, 127, rgba.data(), 5, &error) == CAIRN_USAGE);
  cairn_close(pack);
}

TEST_CASE("C: failures have a code and a line of text, and leave no pack") {
  const OpenPack pack;
  const test::TempDir dir;
  cairn_error error{};
  cairn_pack* other = reinterpret_cast<cairn_pack*>(&error);
  CHECK(cairn_open((dir.path() / "absent.cairn").c_str(), &other, &error) == CAIRN_FAILED);
  CHECK(other == nullptr);
  CHECK(std::string(error.text).find("absent.cairn") != std::string::npos);
  test::write_bytes(dir.path() / "short.cairn", std::vector<std::byte>(50));
  CHECK(cairn_open((dir.path() / "short.cairn").c_str(), &other, nullptr) == CAIRN_BAD_DATA);
  CHECK(other == nullptr);
  cairn_close(nullptr);

  std::vector<float> metres(257 * 257);
  CHECK(cairn_read_heights(pack.get(), 2, 0, 0, metres.data(), metres.size(), &error) == CAIRN_ABSENT);
  CHECK(std::string(error.text).find("2/0/0") != std::string::npos);
  CHECK(cairn_read_heights(pack.get(), 99, 0, 0, metres.data(), metres.size(), &error) == CAIRN_USAGE);
  CHECK(cairn_read_heights(pack.get(), 2, 0, 0, metres.data(), 4, &error) == CAIRN_USAGE);
  CHECK(std::string(cairn_info(pack.get())).front() == '{');
}

TEST_CASE("C: a longer text than there is room for is cut off and ends") {
  cairn_error error{};
  cairn_pack* pack = nullptr;
  const std::string path = "/absent/" + std::string(3000, 'x');
  CHECK(cairn_open(path.c_str(), &pack, &error) != CAIRN_OK);
  CHECK(std::string(error.text).size() == sizeof error.text - 1);
}

}  // namespace
}  // namespace cairn
