#include "builder/app/remedies.h"

#include <string>

namespace cairn {
namespace {

std::string words_for(Remedy remedy, const std::filesystem::path& work) {
  switch (remedy) {
    case Remedy::replace_target:
      return "--force replaces it";
    case Remedy::accept_error:
      return "--allow-error bakes all the same";
    case Remedy::tell_body:
      return "--body NAME,a,b says which";
    case Remedy::tell_latitude:
      return "--latitude planetographic or planetocentric says it";
    case Remedy::resume:
      return "what is baked stays in " + work.string() + ", and --resume goes on from there";
    case Remedy::discard_work:
      return "--force discards it";
  }
  return "";
}

}  // namespace

Error with_remedies(Error error, const std::vector<Remedy>& remedies, const std::filesystem::path& work) {
  for (const Remedy remedy : remedies) error.message += "; " + words_for(remedy, work);
  return error;
}

}  // namespace cairn
