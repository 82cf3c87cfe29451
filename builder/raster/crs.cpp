#include "builder/raster/crs.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

namespace cairn {
namespace {

// WGS 84 (2D and 3D), NAD83, NAD83(HARN), NAD83(NSRS2007), NAD83(CSRS), NAD83(2011), ETRS89, SIRGAS 2000.
constexpr std::array kGeographic = {4326, 4979, 4269, 4152, 4759, 4617, 6318, 4258, 4674};
constexpr std::array kDatums = {6326, 6269, 6152, 6759, 6140, 1116, 6258, 6674};
constexpr std::array kWebMercator = {3857, 3785, 900913, 102100, 102113};

struct UtmCodes {
  int first;
  int first_zone;
  int last_zone;
  bool north;
};
// Runs of codes, one a zone.
constexpr std::array kUtm = {
    UtmCodes{32601, 1, 60, true},  UtmCodes{32701, 1, 60, false},   // WGS 84
    UtmCodes{26901, 1, 23, true},                                   // NAD83
    UtmCodes{6330, 1, 19, true},   UtmCodes{3708, 1, 19, true},     // NAD83(2011), NAD83(NSRS2007)
    UtmCodes{25828, 28, 38, true},                                  // ETRS89
    UtmCodes{31965, 11, 22, true}, UtmCodes{31977, 17, 25, false},  // SIRGAS 2000
};

template <class Codes>
bool contains(const Codes& codes, int code) {
  return std::find(codes.begin(), codes.end(), code) != codes.end();
}

}  // namespace

bool set_utm(Georeference& georeference, int zone, bool north) {
  if (zone < 1 || zone > 60) return false;
  georeference.crs = Georeference::Crs::utm;
  georeference.utm_zone = zone;
  georeference.utm_north = north;
  return true;
}

bool set_crs(Georeference& georeference, int epsg) {
  if (contains(kGeographic, epsg)) {
    georeference.crs = Georeference::Crs::geographic;
    return true;
  }
  if (contains(kWebMercator, epsg)) {
    georeference.crs = Georeference::Crs::web_mercator;
    return true;
  }
  for (const UtmCodes& run : kUtm) {
    const int zone = run.first_zone + epsg - run.first;
    if (zone >= run.first_zone && zone <= run.last_zone) return set_utm(georeference, zone, run.north);
  }
  return false;
}

bool is_near_wgs84(int geodetic_datum) {
  return contains(kDatums, geodetic_datum);
}

void set_other_crs(Georeference& georeference, std::string definition) {
  georeference.crs = Georeference::Crs::other;
  georeference.definition = std::move(definition);
}

double metres_of_unit(int epsg_unit) {
  switch (epsg_unit) {
    case 9001:
      return 1;
    case 9002:
      return 0.3048;
    case 9003:
      return 1200.0 / 3937.0;
    default:
      return 0;
  }
}

double metres_of_unit(std::string_view name) {
  // Files differ in case, blanks and underscores: "Meters", "US_survey_foot", "Foot_US".
  std::string spelt;
  for (const char c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) != 0)
      spelt += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const std::string_view metre :
       {"", "unspecified", "unknown", "m", "metre", "meter", "metres", "meters", "mtr"})
    if (spelt == metre) return 1;
  for (const std::string_view foot : {"ft", "foot", "feet", "internationalfoot", "internationalfeet",
                                      "footinternational", "feetinternational", "footintl", "ftintl", "ift"})
    if (spelt == foot) return metres_of_unit(9002);
  for (const std::string_view foot : {"ussurveyfoot", "ussurveyfeet", "usft", "ftus", "sfoot", "surveyfoot",
                                      "surveyfeet", "footus", "feetus", "usfoot", "usfeet"})
    if (spelt == foot) return metres_of_unit(9003);
  struct Unit {
    std::string_view name;
    double metres;
  };
  constexpr double kYard = 0.9144, kFathom = 1.8288;
  for (const Unit unit :
       {Unit{"km", 1000}, Unit{"kilometre", 1000}, Unit{"kilometer", 1000}, Unit{"dm", 0.1},
        Unit{"decimetre", 0.1}, Unit{"decimeter", 0.1}, Unit{"cm", 0.01}, Unit{"centimetre", 0.01},
        Unit{"centimeter", 0.01}, Unit{"mm", 0.001}, Unit{"millimetre", 0.001}, Unit{"millimeter", 0.001},
        Unit{"yd", kYard}, Unit{"yard", kYard}, Unit{"fathom", kFathom}})
    if (spelt == unit.name || (unit.name.size() > 2 && spelt == std::string(unit.name) + 's'))
      return unit.metres;
  return 0;
}

}  // namespace cairn
