#include "cairn/body.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cairn {
namespace {

struct Known {
  const char* name;
  Ellipsoid shape;
};
// Archinal et al. 2018, as PROJ's IAU_2015 has them; of bodies with three axes the mean radius.
constexpr std::array kKnown = {Known{"Mercury", {2440530, 2438260}},
                               Known{"Venus", {6051800, 6051800}},
                               Known{"Earth", {}},
                               Known{"Moon", {1737400, 1737400}},
                               Known{"Mars", {3396190, 3376200}},
                               Known{"Ceres", {487300, 446000}},
                               Known{"Io", {1821490, 1821490}},
                               Known{"Europa", {1560800, 1560800}},
                               Known{"Ganymede", {2631200, 2631200}},
                               Known{"Callisto", {2410300, 2410300}},
                               Known{"Mimas", {198200, 198200}},
                               Known{"Enceladus", {252100, 252100}},
                               Known{"Tethys", {531000, 531000}},
                               Known{"Dione", {561400, 561400}},
                               Known{"Rhea", {763500, 763500}},
                               Known{"Titan", {2575000, 2575000}},
                               Known{"Iapetus", {745700, 712100}},
                               Known{"Triton", {1352600, 1352600}},
                               Known{"Pluto", {1188300, 1188300}},
                               Known{"Charon", {606000, 606000}}};

constexpr std::size_t kNameBytes = 31;

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

bool is_equal(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](char x, char y) { return lower(x) == lower(y); });
}

bool has_radius(const Ellipsoid& known, double radius_m) {
  constexpr double kTolerance = 0.001;
  return radius_m >= known.semi_minor_m * (1 - kTolerance) &&
         radius_m <= known.semi_major_m * (1 + kTolerance);
}

bool is_close(const Ellipsoid& a, const Ellipsoid& b) {
  constexpr double kClose_m = 0.01;
  return std::abs(a.semi_major_m - b.semi_major_m) <= kClose_m &&
         std::abs(a.semi_minor_m - b.semi_minor_m) <= kClose_m;
}

/// Cut where a character of UTF-8 begins.
std::string cut(std::string_view name) {
  std::size_t length = std::min(name.size(), kNameBytes);
  while (length > 0 && length < name.size() && (static_cast<unsigned char>(name[length]) & 0xC0U) == 0x80U)
    --length;
  return std::string(name.substr(0, length));
}

}  // namespace

std::optional<Body> known_body(std::string_view name) {
  for (const Known& known : kKnown)
    if (is_equal(name, known.name)) return Body{known.name, known.shape};
  return std::nullopt;
}

std::string known_body_names() {
  std::string names;
  for (const Known& known : kKnown) names += (names.empty() ? "" : ", ") + std::string(known.name);
  return names;
}

Body body_of(const Ellipsoid& shape, std::string_view otherwise) {
  for (const Known& known : kKnown) {
    if (!has_radius(known.shape, shape.semi_major_m)) continue;
    Body body{known.name, shape};
    const Ellipsoid sphere{known.shape.semi_major_m, known.shape.semi_major_m};
    if (body.is_earth() || is_close(shape, known.shape))
      body.shape = known.shape;
    else if (is_close(shape, sphere))
      body.shape = sphere;
    return body;
  }
  return {otherwise.empty() ? "unnamed" : cut(otherwise), shape};
}

}  // namespace cairn
