#include "cairn/height_batch.h"

#include <random>

#include <catch2/catch.hpp>

#include "tests/support/flight_pack.h"

namespace cairn {
namespace {

std::vector<LonLat> random_places(std::size_t count) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> lon(27, 30), lat(36, 38), any(-540, 540);
  std::vector<LonLat> places;
  for (std::size_t i = 0; i < count; ++i) {
    places.push_back(i % 3 == 0 ? LonLat{any(random), any(random) / 5} : LonLat{lon(random), lat(random)});
  }
  places.push_back({NAN, 3});
  return places;
}

}  // namespace

TEST_CASE("a batch has what the sampler says of each place, in their order") {
  const test::FlightPack pack;
  const auto reader = pack.open();
  const auto places = random_places(2000);
  HeightBatches batches(reader, 2);
  auto first = batches.sample(places), second = batches.sample(places), empty = batches.sample({});
  const auto heights = first.get(), again = second.get();
  REQUIRE(heights.ok());
  REQUIRE(again.ok());
  REQUIRE(heights->size() == places.size());
  CHECK(empty.get()->empty());
  PackSampler sampler(*reader, 64);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto expected = sampler.height_at(places[i]);
    REQUIRE(expected.ok());
    REQUIRE((*heights)[i].has_value() == expected->has_value());
    REQUIRE((*again)[i].has_value() == expected->has_value());
    if (!*expected) continue;
    REQUIRE((*heights)[i]->metres == (*expected)->metres);
    REQUIRE((*heights)[i]->level == (*expected)->level);
  }
}

TEST_CASE("batches that are stopped end with an error, whether begun or waiting") {
  const test::FlightPack pack;
  const auto reader = pack.open();
  std::stop_source stop;
  stop.request_stop();
  HeightBatches batches(reader, 1);
  const auto stopped = batches.sample(random_places(10), stop.get_token()).get();
  REQUIRE_FALSE(stopped.ok());
  CHECK(stopped.error().code == ErrorCode::failed);
  std::vector<std::future<Result<HeightBatches::Heights>>> futures;
  {
    HeightBatches ended(reader, 1);
    for (int i = 0; i < 20; ++i) futures.push_back(ended.sample(random_places(20000)));
  }
  std::size_t failures = 0;
  for (auto& future : futures) failures += future.get().ok() ? 0 : 1;
  CHECK(failures > 0);
}

}  // namespace cairn
