// Writes a pack with the tiles of the whole Earth, down to a level, each with a block of a few bytes, and
// measures what writing and opening it takes: scripts/bench_index.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <random>
#include <string>

#include "cairn/pack_reader.h"
#include "format/file.h"
#include "format/pack_writer.h"

namespace cairn {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// VmHWM, the most memory that the process has had, in MiB.
double peak_mib() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::strtod(line.c_str() + 6, nullptr) / 1024;
  }
  return 0;
}

/// The tile's address, and what makes its entry look like a real one's.
Status add_tile(PackWriter& writer, const TileId& id, std::mt19937& random) {
  IndexEntry entry;
  entry.id = id;
  entry.min_quanta = static_cast<std::int32_t>(4000 + random() % 2000);
  entry.max_quanta = entry.min_quanta + static_cast<std::int32_t>(random() % 4000);
  entry.geometric_error_m = std::ldexp(1.0f + static_cast<float>(random() % 1000000) * 1e-6f, 3 - id.level);
  std::vector<std::byte> block(sizeof id + random() % 16);
  std::memcpy(block.data(), &id, sizeof id);
  const auto added = writer.add(entry, block);
  return added ? Status() : Status(added.error());
}

/// In the order in which a bake writes tiles: the children of a tile together, once all beneath them is
/// there.
Status add_beneath(PackWriter& writer, const TileId& id, int finest, std::mt19937& random) {
  if (id.level == finest) return {};
  for (int q = 0; q < 4; ++q) {
    const TileId child = child_of(id, q);
    if (!is_valid(child)) continue;
    if (Status status = add_beneath(writer, child, finest, random); !status) return status;
  }
  for (int q = 0; q < 4; ++q) {
    const TileId child = child_of(id, q);
    if (!is_valid(child)) continue;
    if (Status status = add_tile(writer, child, random); !status) return status;
  }
  return {};
}

Status write_earth(const std::string& path, int finest) {
  const auto start = Clock::now();
  auto writer = PackWriter::create(path, PackHeader());
  if (!writer) return writer.error();
  std::mt19937 random(1);
  Status status = add_beneath(*writer, {kMinLevel, 0, 0}, finest, random);
  if (status) status = add_tile(*writer, {kMinLevel, 0, 0}, random);
  const double added = seconds_since(start);
  if (status) status = writer->finish("{}");
  if (status)
    std::printf("written        %.1f s, of which the index %.1f s; peak memory %.0f MiB\n",
                seconds_since(start), seconds_since(start) - added, peak_mib());
  return status;
}

class CountedFile : public ByteSource {
 public:
  explicit CountedFile(File file) : file_(std::move(file)) {}
  const std::filesystem::path& name() const override { return file_.path(); }
  Result<std::uint64_t> size() const override { return file_.size(); }
  bool is_slow() const override { return true; }
  using ByteSource::read;
  Status read(std::uint64_t offset, std::span<std::byte> out) const override {
    ++reads;
    bytes += out.size();
    return file_.read(offset, out);
  }
  mutable std::atomic<std::size_t> reads = 0;
  mutable std::atomic<std::size_t> bytes = 0;

 private:
  File file_;
};

Status count_reads(const std::string& path, const TileId& wanted, const char* which) {
  auto file = File::open_to_read(path);
  if (!file) return file.error();
  auto source = std::make_unique<CountedFile>(std::move(*file));
  const CountedFile& counted = *source;
  const auto pack = PackReader::open(std::move(source));
  if (!pack) return pack.error();
  if (!pack->find(Layer::heights, wanted)) return failed("expected " + to_string(wanted) + ", found none");
  std::printf("%s  %zu reads of %zu bytes in all before it\n", which, counted.reads.load(),
              counted.bytes.load());
  return {};
}

Status measure_local(const std::string& path, int finest) {
  auto start = Clock::now();
  const auto pack = PackReader::open(path);
  if (!pack) return pack.error();
  std::printf("opened         %.3f ms\n", 1e3 * seconds_since(start));
  const PackHeader& header = pack->header();
  std::printf("tiles          %zu, file %.1f MB, index %.1f MB, %.2f bytes per tile\n", pack->entry_count(),
              static_cast<double>(header.file_bytes()) / 1e6,
              static_cast<double>(header.metadata_offset - header.index_offset) / 1e6,
              static_cast<double>(header.metadata_offset - header.index_offset) /
                  static_cast<double>(pack->entry_count()));
  start = Clock::now();
  if (const Status status = pack->read_index(); !status) return status;
  std::printf("whole index    %.2f s\n", seconds_since(start));
  std::mt19937 random(2);
  constexpr int kFinds = 2000000;
  int found = 0;
  start = Clock::now();
  for (int i = 0; i < kFinds; ++i) {
    const TileId id{finest, static_cast<std::int32_t>(random() % static_cast<unsigned>(tiles_around(finest))),
                    static_cast<std::int32_t>(random() % static_cast<unsigned>(tiles_pole_to_pole(finest)))};
    found += pack->find(Layer::heights, id) ? 1 : 0;
  }
  std::printf("find           %.0f ns each, %d of %d found; peak memory %.0f MiB\n",
              1e9 * seconds_since(start) / kFinds, found, kFinds, peak_mib());
  return {};
}

int run(const std::string& verb, const std::string& path, int finest) {
  Status status;
  if (verb == "write") {
    status = write_earth(path, finest);
  } else if (verb == "read") {
    status = count_reads(path, {kMinLevel, 0, 0}, "coarsest tile");
    if (status) status = count_reads(path, tile_at({8.5, 47.4}, finest), "a finest tile");
    if (status) status = measure_local(path, finest);
  } else {
    std::fprintf(stderr, "usage: cairn-index-bench write|read PACK FINEST_LEVEL\n");
    return 2;
  }
  if (!status) std::fprintf(stderr, "%s\n", status.error().message.c_str());
  return status ? 0 : 1;
}

}  // namespace
}  // namespace cairn

int main(int argc, char** argv) {
  return cairn::run(argc == 4 ? argv[1] : "", argc == 4 ? argv[2] : "", argc == 4 ? std::atoi(argv[3]) : 0);
}
