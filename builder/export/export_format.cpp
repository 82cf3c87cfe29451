#include "builder/export/export_format.h"

namespace cairn {

Result<VerticalDatum> datum_of(const PackReader& pack, const ExportOptions& options) {
  const VerticalDatum own = pack.header().vertical_datum;
  if (!options.datum || *options.datum == own) return own;
  if (*options.datum == VerticalDatum::egm96 && !pack.header().body.is_earth())
    return usage_error(pack.path().string() + ": vertical datum: expected one of " + pack.header().body.name +
                       ", found egm96");
  const std::string& other = pack.header().other_datum;
  if (own == VerticalDatum::unknown && other.empty()) return *options.datum;
  return usage_error(pack.path().string() + ": vertical datum: expected " +
                     (other.empty() ? to_string(own) : other) + ", which the pack has, found " +
                     to_string(*options.datum));
}

}  // namespace cairn
