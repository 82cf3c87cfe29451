// The rqt layer of whole bakes.

#include <algorithm>
#include <filesystem>
#include <map>

#include <catch2/catch.hpp>

#include "builder/bake/journal.h"
#include "cairn/build.h"
#include "cairn/pack_reader.h"
#include "format/pack_verify.h"
#include "format/pack_writer.h"
#include "format/rqt_block.h"
#include "tests/support/test_bake.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using test::bake;

BuildOptions options_for(const std::vector<fs::path>& inputs, const fs::path& target, float rqt_m) {
  BuildOptions options = test::bake_options(inputs, target);
  options.heights.rqt_tolerance_m = rqt_m;
  return options;
}

std::map<TileId, RqtSteps> triangulations_of(const PackReader& pack) {
  std::map<TileId, RqtSteps> all;
  for (std::size_t i = 0; i < pack.entry_count(); ++i) {
    const IndexEntry entry = pack.entry(i);
    if (entry.layer != Layer::rqt) continue;
    const auto bytes = pack.read_block(entry);
    REQUIRE(bytes.ok());
    auto block = decode_rqt_block(*bytes, pack.header().tile_size, root_rises(entry.id));
    REQUIRE(block.ok());
    all.emplace(entry.id, std::move(block->vertices));
  }
  return all;
}

// Copies a pack, its rqt blocks changed by `edit`. The order of the blocks stays: siblings lie side by side.
template <class Edit>
void copy_pack(const PackReader& pack, const fs::path& target, const Edit& edit) {
  auto writer = PackWriter::create(target, pack.header());
  REQUIRE(writer.ok());
  std::vector<IndexEntry> entries;
  for (std::size_t i = 0; i < pack.entry_count(); ++i) entries.push_back(pack.entry(i));
  std::stable_sort(entries.begin(), entries.end(),
                   [](const IndexEntry& a, const IndexEntry& b) { return a.offset < b.offset; });
  for (IndexEntry& entry : entries) {
    auto bytes = pack.read_block(entry);
    REQUIRE(bytes.ok());
    if (entry.layer == Layer::rqt) edit(entry, *bytes);
    REQUIRE(writer->add(entry, *bytes).ok());
  }
  REQUIRE(writer->finish(pack.metadata_json()).ok());
}

}  // namespace

TEST_CASE("every height tile gets triangulations that verify, equal on the edges of neighbours", "[data]") {
  const auto data = test::real_data();
  if (!data) return;
  const std::vector<std::vector<fs::path>> inputs{
      {*data / "srtm3/N44W072.hgt"}, {*data / "srtm3/N00W177.hgt"}, {*data / "srtm3/N42E001.hgt.zip"}};
  const test::TempDir dir;
  for (const auto& input : inputs) {
    BuildOptions options = options_for(input, dir.path() / "a.cairn", 4);
    options.heights.voids = VoidMode::keep;
    bake(options);
    const auto verified = verify_pack(options.session.target, {2, 10});
    REQUIRE(verified.ok());
    for (const Finding& f : verified->findings) UNSCOPED_INFO(f.where << ": " << f.what);
    CHECK(verified->ok());
    const auto pack = PackReader::open(options.session.target);
    REQUIRE(pack.ok());
    const auto all = triangulations_of(*pack);
    std::size_t heights = 0;
    for (std::size_t i = 0; i < pack->entry_count(); ++i)
      heights += pack->entry(i).layer == Layer::heights ? 1 : 0;
    CHECK(all.size() == heights);
    for (const auto& [id, own] : all) {
      const auto east = all.find(neighbour_of(id, 1, 0)), north = all.find(neighbour_of(id, 0, 1));
      for (int i = 0; i < own.size(); ++i) {
        if (east != all.end()) REQUIRE(own.at(own.size() - 1, i) == east->second.at(0, i));
        if (north != all.end()) REQUIRE(own.at(i, own.size() - 1) == north->second.at(i, 0));
      }
    }
  }
}

TEST_CASE("triangulations of the whole Earth verify, overhanging tiles included") {
  const test::TempDir dir;
  const BuildOptions options =
      options_for({test::sample_dem() / "etopo5_thinned.tif"}, dir.path() / "a.cairn", 50);
  bake(options);
  const auto verified = verify_pack(options.session.target, {2, 10});
  REQUIRE(verified.ok());
  for (const Finding& f : verified->findings) UNSCOPED_INFO(f.where << ": " << f.what);
  CHECK(verified->ok());
}

TEST_CASE("verify finds triangulations that are not those of the heights", "[slow]") {
  const test::TempDir dir;
  const BuildOptions options =
      options_for({test::sample_dem() / "jacksboro_fault.tif"}, dir.path() / "a.cairn", 2);
  bake(options);
  const auto pack = PackReader::open(options.session.target);
  REQUIRE(pack.ok());
  const TileId victim = triangulations_of(*pack).rbegin()->first;
  const fs::path damaged = dir.path() / "b.cairn";
  const auto findings = [&](const auto& edit) {
    copy_pack(*pack, damaged, [&](IndexEntry& entry, std::vector<std::byte>& bytes) {
      if (entry.id == victim) edit(entry, bytes);
    });
    const auto verified = verify_pack(damaged, {1, 10});
    REQUIRE(verified.ok());
    return verified->findings;
  };
  const auto unchanged = findings([](IndexEntry&, std::vector<std::byte>&) {});
  for (const Finding& f : unchanged) UNSCOPED_INFO(f.where << ": " << f.what);
  CHECK(unchanged.empty());
  const auto added = findings([&](IndexEntry& entry, std::vector<std::byte>& bytes) {
    auto block = decode_rqt_block(bytes, pack->header().tile_size, root_rises(entry.id));
    REQUIRE(block.ok());
    for (int i = 1; i < 20; ++i) block->vertices.raise(i, 2 * i + 1, block->steps);
    bytes = encode_rqt_block(*block);
  });
  REQUIRE_FALSE(added.empty());
  CHECK(added.front().where == "rqt " + to_string(victim));
  CHECK_FALSE(findings([](IndexEntry& entry, std::vector<std::byte>&) { entry.max_quanta += 1; }).empty());
  CHECK_FALSE(
      findings([](IndexEntry&, std::vector<std::byte>& bytes) { bytes.resize(bytes.size() - 1); }).empty());
}

TEST_CASE("a bake cut off among the triangulations goes on to the same bytes, whatever the threads", "[slow]") {
  const test::TempDir dir;
  BuildOptions options =
      options_for({test::sample_dem() / "jacksboro_fault.tif"}, dir.path() / "whole.cairn", 1);
  options.grid.tile_size = 257;
  options.mosaic.level = 5;
  bake(options);
  const auto expected = test::read_bytes(options.session.target);
  options.session.threads = 1;
  options.session.target = dir.path() / "cut.cairn";
  bake(options);
  CHECK(test::read_bytes(options.session.target) == expected);
  options.session.resume = true;
  for (const int cut_after : {1, 2, 4}) {
    fs::remove(options.session.target);
    int calls = 0;
    CHECK_FALSE(
        build(options, [&](const Progress& p) { return p.stage != "rqt" || ++calls < cut_after; }).ok());
    CHECK(calls == cut_after);
    CHECK(fs::exists(Journal::path_for(options.session.target)));
    const auto report = build(options, [](const Progress&) { return true; });
    REQUIRE(report.ok());
    CHECK(report->resumed);
    CHECK(test::read_bytes(options.session.target) == expected);
  }
}

}  // namespace cairn
