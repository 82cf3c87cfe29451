// cairn-make-dem: synthetic DEMs of any size for the benches, written window by window.
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <tiffio.h>

#include "tests/support/synthetic_relief.h"

namespace {

constexpr int kTile = 512;

struct Options {
  double west = 0, south = 0, east = 1, north = 1;
  int posts = 4096;
  std::string format = "cells";
  std::filesystem::path out;
  bool compress = false;
  bool strips = false;
  unsigned seed = 1;
  unsigned threads = 2;
};

/// A raster whose first post is the north-western one, at (x, y) in posts east of Greenwich and north of the
/// equator.
struct Raster {
  std::filesystem::path path;
  std::int64_t x = 0;
  std::int64_t y = 0;
  std::int64_t columns = 0;
  std::int64_t rows = 0;
};

struct CloseTiff {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
using Tiff = std::unique_ptr<TIFF, CloseTiff>;

void register_tags(TIFF* tiff) {
  static char names[][16] = {"PixelScale", "Tiepoints", "GeoKeys"};
  static const TIFFFieldInfo fields[] = {
      {33550, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, names[0]},
      {33922, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, names[1]},
      {34735, -1, -1, TIFF_SHORT, FIELD_CUSTOM, 1, 1, names[2]},
  };
  TIFFMergeFieldInfo(tiff, fields, 3);
}

/// WGS84, degrees, pixel-is-point.
void write_place(TIFF* tiff, const Raster& raster, int posts) {
  register_tags(tiff);
  const double scale[] = {1.0 / posts, 1.0 / posts, 0};
  const double tiepoint[] = {
      0, 0, 0, static_cast<double>(raster.x) / posts, static_cast<double>(raster.y) / posts, 0};
  const std::uint16_t keys[] = {1, 1, 0, 4, 1024, 0, 1, 2, 1025, 0, 1, 2, 2048, 0, 1, 4326, 2054, 0, 1, 9102};
  TIFFSetField(tiff, 33550, 3, scale);
  TIFFSetField(tiff, 33922, 6, tiepoint);
  TIFFSetField(tiff, 34735, 20, keys);
}

Tiff create(const Raster& raster, const Options& options) {
  const bool big = raster.columns * raster.rows * 2 > std::int64_t{4000} << 20;
  Tiff tiff(TIFFOpen(raster.path.c_str(), big ? "w8" : "w"));
  if (!tiff) return tiff;
  TIFFSetField(tiff.get(), TIFFTAG_IMAGEWIDTH, static_cast<std::uint32_t>(raster.columns));
  TIFFSetField(tiff.get(), TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(raster.rows));
  TIFFSetField(tiff.get(), TIFFTAG_BITSPERSAMPLE, 16);
  TIFFSetField(tiff.get(), TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_INT);
  TIFFSetField(tiff.get(), TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(tiff.get(), TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff.get(), TIFFTAG_COMPRESSION,
               options.compress ? COMPRESSION_ADOBE_DEFLATE : COMPRESSION_NONE);
  if (options.compress) TIFFSetField(tiff.get(), TIFFTAG_PREDICTOR, PREDICTOR_HORIZONTAL);
  if (options.strips) {
    TIFFSetField(tiff.get(), TIFFTAG_ROWSPERSTRIP, 1);
  } else {
    TIFFSetField(tiff.get(), TIFFTAG_TILEWIDTH, kTile);
    TIFFSetField(tiff.get(), TIFFTAG_TILELENGTH, kTile);
  }
  write_place(tiff.get(), raster, options.posts);
  return tiff;
}

/// Tiles of one row of tiles, worked out by several threads; past the raster's edges the relief goes on.
std::vector<std::vector<std::int16_t>> row_of_tiles(const cairn::bench::SyntheticRelief& relief,
                                                    const Raster& raster, std::int64_t top,
                                                    unsigned threads) {
  const auto count = static_cast<std::size_t>((raster.columns + kTile - 1) / kTile);
  std::vector<std::vector<std::int16_t>> tiles(count, std::vector<std::int16_t>(kTile * kTile));
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    std::vector<std::int16_t> north_up(kTile * kTile);
    for (std::size_t i = next++; i < count; i = next++) {
      relief.heights(raster.x + static_cast<std::int64_t>(i) * kTile, raster.y - top - (kTile - 1), kTile,
                     kTile, north_up);
      for (std::size_t r = 0; r < kTile; ++r)
        std::copy_n(north_up.begin() + static_cast<std::ptrdiff_t>((kTile - 1 - r) * kTile), kTile,
                    tiles[i].begin() + static_cast<std::ptrdiff_t>(r * kTile));
    }
  };
  std::vector<std::jthread> workers;
  for (unsigned t = 0; t < threads; ++t) workers.emplace_back(work);
  workers.clear();
  return tiles;
}

bool write_tiles(TIFF* tiff, std::int64_t top, std::vector<std::vector<std::int16_t>>& tiles) {
  for (std::size_t i = 0; i < tiles.size(); ++i)
    if (TIFFWriteTile(tiff, tiles[i].data(), static_cast<std::uint32_t>(i * kTile),
                      static_cast<std::uint32_t>(top), 0, 0) < 0)
      return false;
  return true;
}

bool write_strips(TIFF* tiff, const Raster& raster, std::int64_t top,
                  const std::vector<std::vector<std::int16_t>>& tiles) {
  std::vector<std::int16_t> row(tiles.size() * kTile);
  for (std::int64_t r = 0; r < kTile && top + r < raster.rows; ++r) {
    for (std::size_t i = 0; i < tiles.size(); ++i)
      std::copy_n(tiles[i].begin() + r * kTile, kTile, row.begin() + static_cast<std::ptrdiff_t>(i * kTile));
    if (TIFFWriteScanline(tiff, row.data(), static_cast<std::uint32_t>(top + r), 0) != 1) return false;
  }
  return true;
}

bool write_raster(const cairn::bench::SyntheticRelief& relief, const Raster& raster, const Options& options) {
  const Tiff tiff = create(raster, options);
  if (!tiff) return false;
  for (std::int64_t top = 0; top < raster.rows; top += kTile) {
    auto tiles = row_of_tiles(relief, raster, top, options.threads);
    const bool written =
        options.strips ? write_strips(tiff.get(), raster, top, tiles) : write_tiles(tiff.get(), top, tiles);
    if (!written) return false;
  }
  return true;
}

std::string cell_name(int lon, int lat) {
  return fmt::format("{}{:02}{}{:03}.tif", lat < 0 ? 'S' : 'N', std::abs(lat), lon < 0 ? 'W' : 'E',
                     std::abs(lon));
}

std::vector<Raster> rasters_of(const Options& o) {
  if (o.format == "geotiff") {
    const std::int64_t x = std::lround(o.west * o.posts), y = std::lround(o.north * o.posts);
    return {{o.out, x, y, std::lround(o.east * o.posts) - x + 1, y - std::lround(o.south * o.posts) + 1}};
  }
  std::vector<Raster> cells;
  for (int lat = static_cast<int>(o.south); lat < o.north; ++lat)
    for (int lon = static_cast<int>(o.west); lon < o.east; ++lon)
      cells.push_back({o.out / cell_name(lon, lat), std::int64_t{lon} * o.posts,
                       std::int64_t{lat + 1} * o.posts, o.posts + 1, o.posts + 1});
  return cells;
}

void add_options(CLI::App& app, Options& o) {
  app.add_option("--west", o.west, "degrees")->check(CLI::Range(-180, 180))->required();
  app.add_option("--south", o.south, "degrees")->check(CLI::Range(-90, 90))->required();
  app.add_option("--east", o.east, "degrees")->check(CLI::Range(-180, 180))->required();
  app.add_option("--north", o.north, "degrees")->check(CLI::Range(-90, 90))->required();
  app.add_option("--posts", o.posts, "posts a degree")->check(CLI::Range(1, 1 << 20))->capture_default_str();
  app.add_option("--format", o.format,
                 "cells: one GeoTIFF a 1x1 degree cell, in the folder --out; geotiff: one file, --out")
      ->check(CLI::IsMember({"cells", "geotiff"}))
      ->capture_default_str();
  app.add_option("--out", o.out, "folder or file")->required();
  app.add_flag("--compress", o.compress, "deflate with predictor 2; else plain");
  app.add_flag("--strips", o.strips, "strips of one row; else tiles of 512x512");
  app.add_option("--seed", o.seed, "another seed, another land")->capture_default_str();
  app.add_option("--threads", o.threads, "threads")->check(CLI::Range(1, 256))->capture_default_str();
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"Writes synthetic DEMs: int16 metres, WGS84, pixel-is-point"};
  add_options(app, options);
  CLI11_PARSE(app, argc, argv);
  if (options.west >= options.east || options.south >= options.north) {
    fmt::print(stderr, "cairn-make-dem: expected west < east and south < north\n");
    return 2;
  }
  std::error_code ignored;
  if (options.format == "cells") std::filesystem::create_directories(options.out, ignored);
  const cairn::bench::SyntheticRelief relief(options.posts, options.seed);
  std::int64_t posts = 0;
  for (const Raster& raster : rasters_of(options)) {
    if (!write_raster(relief, raster, options)) {
      fmt::print(stderr, "cairn-make-dem: {}: cannot be written\n", raster.path.string());
      return 1;
    }
    posts += raster.columns * raster.rows;
  }
  fmt::print("{} posts\n", posts);
  return 0;
}
