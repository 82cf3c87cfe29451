#include <cairn/build.h>
#include <cairn/vertical_conversion.h>

#include <cstdio>

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: bake DEM PACK\n"), 2;
  cairn::BuildOptions options;
  options.mosaic.inputs = {argv[1]};
  options.mosaic.datum = cairn::VerticalDatum::ellipsoid;
  options.session.target = argv[2];
  options.session.threads = 1;
  const auto report = cairn::build(options, [](const cairn::Progress&) { return true; });  // false cancels
  if (!report) return std::fprintf(stderr, "%s\n", report.error().message.c_str()), 1;
  const auto pack = cairn::PackReader::open(options.session.target);
  if (!pack || !cairn::VerticalConversion::open(*pack)) return 1;
  std::printf("%llu samples\n", static_cast<unsigned long long>(report->samples));
}
