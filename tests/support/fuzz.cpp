#include "tests/support/fuzz.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <memory>
#include <random>

#include "tests/support/test_pack.h"

namespace cairn::test {
namespace {

using Bytes = std::vector<std::byte>;
using Random = std::mt19937_64;

/// Below `count`; 0 where that is 0. Small numbers are more frequent: headers are at the start.
std::size_t place_in(Random& random, std::size_t count) {
  if (count == 0) return 0;
  return random() % 3 == 0 ? random() % std::min<std::size_t>(count, 128) : random() % count;
}

void flip(Bytes& bytes, Random& random) {
  if (!bytes.empty()) bytes[place_in(random, bytes.size())] ^= std::byte{1} << (random() % 8);
}

void cut(Bytes& bytes, Random& random) {
  bytes.resize(place_in(random, bytes.size()));
}

void insert(Bytes& bytes, Random& random) {
  const auto at = bytes.begin() + static_cast<std::ptrdiff_t>(place_in(random, bytes.size()));
  bytes.insert(at, 1 + random() % 9, static_cast<std::byte>(random()));
}

/// Numbers that break arithmetic, in 1 to 8 bytes of either order.
void overwrite(Bytes& bytes, Random& random) {
  constexpr std::array<std::uint64_t, 8> numbers = {0,          1,          0x7F,       0xFFFF,
                                                    0x7FFFFFFF, 0x80000000, UINT64_MAX, 0x8000000000000000};
  std::uint64_t number = numbers[random() % numbers.size()];
  if (random() % 2 == 0) number = __builtin_bswap64(number);
  const std::size_t at = place_in(random, bytes.size());
  const std::size_t count = std::min<std::size_t>(std::size_t{1} << random() % 4, bytes.size() - at);
  std::memcpy(bytes.data() + at, &number, count);
}

void move(Bytes& bytes, Random& random) {
  const std::size_t from = place_in(random, bytes.size()), to = place_in(random, bytes.size());
  const std::size_t count = std::min<std::size_t>(random() % 64, bytes.size() - std::max(from, to));
  std::memmove(bytes.data() + to, bytes.data() + from, count);
}

/// The files of the folder in the order of their names.
void add_corpus(const std::filesystem::path& folder, std::vector<Bytes>& seeds) {
  if (!std::filesystem::is_directory(folder)) return;
  std::vector<std::filesystem::path> files;
  for (const auto& file : std::filesystem::directory_iterator(folder)) files.push_back(file.path());
  std::sort(files.begin(), files.end());
  for (const auto& file : files) seeds.push_back(read_bytes(file));
}

}  // namespace

void run_fuzz(const std::string& name, FuzzTarget target, const std::vector<Bytes>& given, int count) {
  std::vector<Bytes> seeds = given;
  add_corpus(std::filesystem::path(CAIRN_FUZZ_CORPUS) / name, seeds);
  constexpr std::array mutations = {flip, flip, overwrite, overwrite, move, insert, cut};
  Random random(20260101);
  for (int i = 0; i < count; ++i) {
    Bytes bytes = seeds[random() % seeds.size()];
    for (std::size_t n = random() % 5; n-- > 0;) mutations[random() % mutations.size()](bytes, random);
    const std::unique_ptr<std::byte[]> exact(new std::byte[bytes.size()]);
    std::copy(bytes.begin(), bytes.end(), exact.get());
    target({exact.get(), bytes.size()});
  }
}

}  // namespace cairn::test
