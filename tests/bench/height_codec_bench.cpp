// Bits a sample and speeds of the height codecs and their peers, on sets of tiles of real terrain.
//
//   cairn-height-codec-bench [--size N] [--repeat N] [--csv FILE] NAME[@RELIEF]=FILE[,FILE...] ...
//
// A FILE is an .hgt, an .hgt.zip or a .cairn pack, of which the finest level's tiles count. Tiles with voids
// and, with @RELIEF, tiles whose heights differ by less are left out; at most 36 are taken, evenly spread.
// Times are one thread's CPU time, the best of the repetitions.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <time.h>

#include "format/codec.h"
#include "cairn/pack_reader.h"
#include "tests/bench/height_codec_peers.h"

namespace {

using namespace cairn;
using Tile = std::vector<std::int32_t>;

constexpr std::size_t kMostTiles = 36;

struct TileSet {
  std::string name;
  std::vector<Tile> tiles;
};

struct Figures {
  double bits = 0;             ///< a sample
  double encode_msamples = 0;  ///< a second
  double decode_gb = 0;        ///< a second, of int16
};

[[noreturn]] void fail(const std::string& message) {
  std::cerr << "cairn-height-codec-bench: " << message << "\n";
  std::exit(1);
}

std::string read_all(const std::string& path) {
  if (!path.ends_with(".zip")) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  }
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(::popen(("unzip -p '" + path + "'").c_str(), "r"),
                                                   ::pclose);
  std::string bytes;
  char buffer[65536];
  for (std::size_t got; (got = std::fread(buffer, 1, sizeof buffer, pipe.get())) > 0;)
    bytes.append(buffer, got);
  return bytes;
}

void add_hgt(const std::string& path, int size, int relief, std::vector<Tile>& tiles) {
  const std::string bytes = read_all(path);
  const int posts = static_cast<int>(std::lround(std::sqrt(static_cast<double>(bytes.size()) / 2)));
  if (posts != 1201 && posts != 3601) fail(path + ": not an .hgt of 1201 or 3601 posts");
  const auto post = [&](int column, int row) {
    const auto at = static_cast<std::size_t>(2 * ((posts - 1 - row) * posts + column));
    return static_cast<std::int16_t>(static_cast<unsigned char>(bytes[at]) << 8 |
                                     static_cast<unsigned char>(bytes[at + 1]));
  };
  for (int south = 0; south + size <= posts; south += size - 1) {
    for (int west = 0; west + size <= posts; west += size - 1) {
      Tile tile;
      for (int row = 0; row < size; ++row) {
        for (int column = 0; column < size; ++column) tile.push_back(post(west + column, south + row));
      }
      const auto [low, high] = std::minmax_element(tile.begin(), tile.end());
      if (*low > -32000 && *high - *low >= relief) tiles.push_back(std::move(tile));
    }
  }
}

void add_pack(const std::string& path, int size, int relief, std::vector<Tile>& tiles) {
  const auto pack = PackReader::open(path);
  if (!pack) fail(pack.error().message);
  if (pack->header().tile_size != size) fail(path + ": its tiles are of another size");
  const auto levels = pack->levels(Layer::heights);
  for (std::size_t i = 0; levels && i < pack->entry_count(); ++i) {
    const IndexEntry entry = pack->entry(i);
    const double range = (entry.max_quanta - entry.min_quanta) * pack->header().quantum_m;
    if (entry.layer != Layer::heights || entry.id.level != levels->finest || (entry.flags & kConstant) != 0 ||
        (entry.flags & kHasVoids) != 0 || entry.filled != 0 || range < relief) {
      continue;
    }
    auto tile = pack->read_height_tile(entry);
    if (!tile) fail(tile.error().message);
    tiles.push_back(std::move(tile->samples));
  }
}

TileSet load(const std::string& argument, int size) {
  const auto equals = argument.find('=');
  if (equals == std::string::npos) fail(argument + ": expected NAME=FILE[,FILE...]");
  TileSet set{argument.substr(0, equals), {}};
  int relief = 0;
  if (const auto at = set.name.find('@'); at != std::string::npos) {
    relief = std::atoi(set.name.c_str() + at + 1);
    set.name.resize(at);
  }
  std::istringstream files(argument.substr(equals + 1));
  for (std::string file; std::getline(files, file, ',');) {
    (file.ends_with(".cairn") ? add_pack : add_hgt)(file, size, relief, set.tiles);
  }
  const std::size_t found = set.tiles.size();
  if (found == 0) fail(set.name + ": no tile");
  for (std::size_t i = 0; found > kMostTiles && i < kMostTiles; ++i) {
    std::swap(set.tiles[i], set.tiles[i * found / kMostTiles]);
  }
  set.tiles.resize(std::min(found, kMostTiles));
  return set;
}

double cpu_seconds() {
  timespec t;
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec) * 1e-9;
}

Figures measure(const bench::Coder& coder, const TileSet& set, int size, int repeat) {
  double encode = std::numeric_limits<double>::max();
  double decode = encode;
  std::size_t bytes = 0;
  Tile decoded(set.tiles[0].size());
  for (int round = 0; round < repeat; ++round) {
    std::vector<std::vector<std::byte>> codes(set.tiles.size());
    double start = cpu_seconds();
    for (std::size_t i = 0; i < set.tiles.size(); ++i) coder.encode(set.tiles[i], size, codes[i]);
    encode = std::min(encode, cpu_seconds() - start);
    double spent = 0;
    bytes = 0;
    for (std::size_t i = 0; i < set.tiles.size(); ++i) {
      start = cpu_seconds();
      const bool ok = coder.decode(codes[i], size, decoded);
      spent += cpu_seconds() - start;
      if (!ok || decoded != set.tiles[i]) fail(coder.name + ": not lossless on " + set.name);
      bytes += codes[i].size();
    }
    decode = std::min(decode, spent);
  }
  const double samples = static_cast<double>(set.tiles.size() * decoded.size());
  return {static_cast<double>(bytes) * 8 / samples, samples / encode / 1e6, samples * 2 / decode / 1e9};
}

std::vector<bench::Coder> all_coders() {
  std::vector<bench::Coder> coders;
  for (const HeightCodec* codec : height_codecs()) {
    coders.push_back({std::string("cairn ") + codec->name, codec->encode,
                      [codec](std::span<const std::byte> code, int size, std::span<std::int32_t> samples) {
                        return codec->decode(code, size, samples).ok();
                      }});
  }
  std::ranges::move(bench::peers(), std::back_inserter(coders));
  return coders;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Measures the height codecs and their peers.");
  int size = 513;
  int repeat = 5;
  std::string csv_path;
  std::vector<std::string> arguments;
  app.add_option("--size", size, "Samples along a tile's side")->check(CLI::Range(2, 4097));
  app.add_option("--repeat", repeat, "Repetitions, of which the best counts")->check(CLI::Range(1, 1000));
  app.add_option("--csv", csv_path, "Write the table to this file too");
  app.add_option("SETS", arguments, "NAME[@RELIEF]=FILE[,FILE...]")->required();
  CLI11_PARSE(app, argc, argv);

  // A bake has freed larger blocks before; then the C library keeps memory rather than asking for it each
  // time.
  void* volatile larger = std::malloc(std::size_t{16} << 20);
  std::free(larger);

  std::ofstream csv(csv_path);
  csv << "set,tiles,codec,bits_per_sample,encode_msamples_per_s,decode_gb_per_s\n";
  for (const std::string& argument : arguments) {
    const TileSet set = load(argument, size);
    fmt::print("{} ({} tiles of {}²)\n{:28} {:>12} {:>17} {:>15}\n", set.name, set.tiles.size(), size, "",
               "bits/sample", "encode Msample/s", "decode GB/s");
    for (const bench::Coder& coder : all_coders()) {
      const Figures f = measure(coder, set, size, repeat);
      fmt::print("{:28} {:12.3f} {:17.1f} {:15.3f}\n", coder.name, f.bits, f.encode_msamples, f.decode_gb);
      csv << fmt::format("{},{},\"{}\",{:.4f},{:.2f},{:.4f}\n", set.name, set.tiles.size(), coder.name,
                         f.bits, f.encode_msamples, f.decode_gb);
    }
    fmt::print("\n");
    std::fflush(stdout);
  }
}
