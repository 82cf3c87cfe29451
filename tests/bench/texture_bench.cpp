// cairn-texture-bench [--rounds N] IMAGE...: speed against quality of the texture encoders and of two
// libraries, as CSV.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <squish.h>
#include <time.h>

#include "builder/texture_encode/texture_encode.h"
#include "tests/support/test_image.h"

#define STB_DXT_IMPLEMENTATION
#include <stb/stb_dxt.h>

namespace {

using namespace cairn;

using Encoder = std::function<void(const test::TestImage&, std::vector<std::byte>&)>;

struct Entry {
  std::string encoder, quality;
  TextureFormat format;
  Encoder encode;
};

double thread_seconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

Entry cairn_entry(TextureFormat format, TextureQuality quality, KernelIsa isa) {
  const char* names[] = {"fast", "normal", "best"};
  const char* encoders[] = {"cairn-portable", "cairn-avx2", "cairn-avx512"};
  return {isa == widest_kernel_isa() ? "cairn" : encoders[static_cast<int>(isa)],
          names[static_cast<int>(quality)], format,
          [=](const test::TestImage& image, std::vector<std::byte>& out) {
            encode_texture_with(isa, format, quality, image.rgba, image.width, image.height, out);
          }};
}

// A library that takes one block at a time. REQUIRES: sizes that are multiples of 4.
Entry block_entry(const char* library, const char* quality,
                  std::function<void(const std::uint8_t*, std::byte*)> encode) {
  return {library, quality, TextureFormat::bc1,
          [=](const test::TestImage& image, std::vector<std::byte>& out) {
            out.resize(texture_bytes(TextureFormat::bc1, image.width, image.height));
            std::byte* at = out.data();
            const auto width = static_cast<std::size_t>(image.width),
                       height = static_cast<std::size_t>(image.height);
            for (std::size_t y = 0; y < height; y += 4) {
              for (std::size_t x = 0; x < width; x += 4, at += 8) {
                std::uint8_t texels[64];
                for (std::size_t row = 0; row < 4; ++row) {
                  std::memcpy(texels + 16 * row, &image.rgba[4 * ((y + row) * width + x)], 16);
                }
                encode(texels, at);
              }
            }
          }};
}

std::vector<Entry> entries() {
  std::vector<Entry> all;
  for (const TextureFormat format : {TextureFormat::bc1, TextureFormat::bc3, TextureFormat::bc7}) {
    for (const TextureQuality quality :
         {TextureQuality::fast, TextureQuality::normal, TextureQuality::best}) {
      for (const KernelIsa isa : {KernelIsa::avx512, KernelIsa::avx2, KernelIsa::portable}) {
        if (isa <= widest_kernel_isa()) all.push_back(cairn_entry(format, quality, isa));
      }
    }
  }
  for (const auto& [name, mode] :
       {std::pair{"normal", STB_DXT_NORMAL}, std::pair{"high", STB_DXT_HIGHQUAL}}) {
    all.push_back(block_entry("stb_dxt", name, [mode = mode](const std::uint8_t* texels, std::byte* out) {
      stb_compress_dxt_block(reinterpret_cast<unsigned char*>(out), texels, 0, mode);
    }));
  }
  for (const auto& [name, fit] : {std::pair{"range fit", squish::kColourRangeFit},
                                  std::pair{"cluster fit", squish::kColourClusterFit}}) {
    all.push_back(block_entry("libsquish", name, [fit = fit](const std::uint8_t* texels, std::byte* out) {
      squish::Compress(texels, out, squish::kDxt1 | fit);
    }));
  }
  return all;
}

// Best of the rounds, in CPU time of this thread: others may load the machine. Encoders slower than a second
// run once.
double best_seconds(const Entry& entry, const test::TestImage& image, int rounds,
                    std::vector<std::byte>& out) {
  double best = 0;
  for (int round = 0; round < rounds && best < 1; ++round) {
    out.clear();
    const double start = thread_seconds();
    entry.encode(image, out);
    const double seconds = thread_seconds() - start;
    best = round == 0 ? seconds : std::min(best, seconds);
  }
  return best;
}

test::TestImage cut_to_blocks(const test::TestImage& image) {
  test::TestImage cut{image.width / 4 * 4, image.height / 4 * 4, {}};
  for (int y = 0; y < cut.height; ++y) {
    const auto row = image.rgba.begin() + static_cast<std::ptrdiff_t>(4) * y * image.width;
    cut.rgba.insert(cut.rgba.end(), row, row + 4 * cut.width);
  }
  return cut;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Speed against quality of texture encoders, on one core; CSV on stdout");
  std::vector<std::string> paths;
  int rounds = 5;
  app.add_option("images", paths,
                 "pictures that OpenImageIO reads, the top left 2048x3072 texels; alpha is ignored")
      ->required();
  app.add_option("--rounds", rounds, "runs of which the best counts")->check(CLI::Range(1, 1000));
  CLI11_PARSE(app, argc, argv);

  std::cout << "image,encoder,format,quality,mpix_per_s,psnr_db\n";
  for (const std::string& path : paths) {
    const test::TestImage image = cut_to_blocks(test::photo(path, 2048, 3072));
    if (image.rgba.empty()) {
      std::cerr << path << ": expected a picture of at least 4x4 texels, found none\n";
      return 3;
    }
    for (const Entry& entry : entries()) {
      std::vector<std::byte> out;
      const double seconds = best_seconds(entry, image, rounds, out);
      fmt::print("{},{},bc{},{},{:.2f},{:.3f}\n", std::filesystem::path(path).stem().string(), entry.encoder,
                 static_cast<int>(entry.format), entry.quality, image.width * image.height / seconds / 1e6,
                 test::psnr_db(image, entry.format, out));
      std::cout.flush();
    }
  }
}
