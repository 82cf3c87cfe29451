#include "cairn/body.h"

#include <string>

#include <catch2/catch.hpp>

namespace cairn {

TEST_CASE("a body is found by its radii, with the semi-axes of the IAU where they are meant") {
  struct Case {
    Ellipsoid shape;
    Body body;
  };
  const Ellipsoid mars{3396190, 3376200}, mars_sphere{3396190, 3396190};
  for (const Case& c : {
           Case{{1737400, 1737400}, {"Moon", {1737400, 1737400}}},
           {{1738000, 1738000}, {"Moon", {1738000, 1738000}}},
           {mars, {"Mars", mars}},
           {{3396190, 3396190 * (1 - 1 / 169.894447)}, {"Mars", mars}},  // as WKT rounds it
           {mars_sphere, {"Mars", mars_sphere}},
           {{3376200, 3376200}, {"Mars", {3376200, 3376200}}},  // GDAL's sphere of polar maps
           {{3389500, 3389500}, {"Mars", {3389500, 3389500}}},
           {{6051800, 6051800}, {"Venus", {6051800, 6051800}}},
           {{6371229, 6371229}, {}},          // of weather models
           {{6377397.155, 6356078.963}, {}},  // Bessel 1841
           {{6378249.145, 6356514.966}, {}},  // Clarke 1880
           {{2439400, 2439400}, {"Mercury", {2439400, 2439400}}},
           {{2575000, 2575000}, {"Titan", {2575000, 2575000}}},
       }) {
    const Body found = body_of(c.shape, "other");
    INFO(c.shape.semi_major_m << " " << found.name << " " << found.shape.semi_minor_m);
    CHECK(found == c.body);
  }
}

TEST_CASE("other bodies have the name that is given, cut to what a header holds") {
  CHECK(body_of({255000, 229000}, "Vesta").name == "Vesta");
  CHECK(body_of({255000, 229000}, "").name == "unnamed");
  const std::string umlauts =
      "Ä" + std::string(29, 'x') + "ö";  // two bytes each: the 32nd byte is half a letter
  const std::string cut = body_of({255000, 229000}, umlauts).name;
  CHECK(cut == "Ä" + std::string(29, 'x'));
}

TEST_CASE("bodies are known by name in any case") {
  CHECK(known_body("mars") == Body{"Mars", {3396190, 3376200}});
  CHECK(known_body("EARTH") == Body{});
  CHECK_FALSE(known_body("Mar"));
  CHECK_FALSE(known_body(""));
  CHECK(known_body_names().find("Moon, Mars") != std::string::npos);
}

TEST_CASE("tangents of planetographic and planetocentric latitudes differ by the square of the axes' ratio") {
  CHECK(Ellipsoid{2, 1}.graphic_per_centric() == 4);
  CHECK(Ellipsoid{2, 2}.graphic_per_centric() == 1);
  CHECK(Ellipsoid().equator_degree_m() == Approx(111319.4908));
}

}  // namespace cairn
