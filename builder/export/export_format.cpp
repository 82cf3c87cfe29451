#include "builder/export/export_format.h"

namespace cairn {

Result<VerticalDatum> datum_of(const PackReader& pack, const ExportOptions& options) {
  const VerticalDatum own = pack.header().vertical_datum;
  if (!options.datum || *options.datum == own) return own;
  if (own == VerticalDatum::unknown) return *options.datum;
  return usage_error(pack.path().string() + ": vertical datum: expected " + to_string(own) +
                     ", which the pack has, found " + to_string(*options.datum));
}

}  // namespace cairn
