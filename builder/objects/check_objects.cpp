#include "builder/objects/check_objects.h"

#include <string>

#include "builder/objects/model_library.h"
#include "builder/objects/place_files.h"

namespace cairn {

Status check_objects(const ObjectOptions& options) {
  if (options.places.empty()) return {};
  auto library = ModelLibrary::open(options.models);
  if (!library) return library.error();
  std::string last;
  bool is_empty = true;
  const auto check_model = [&](const std::string& name) -> Status {
    is_empty = false;
    if (name == last) return {};
    const auto found = library->find(name);
    if (!found) return found.error();
    const auto model = library->load(*found);
    if (!model) return model.error();
    last = name;
    return {};
  };
  const PlaceVisitor visitor{[&](const ObjectPlace& place) { return check_model(place.model); },
                             [&](const ScatterArea& area) -> Status {
                               for (const ScatterRule::Share& share : area.rule.models) {
                                 if (auto status = check_model(share.model); !status) return status;
                               }
                               return {};
                             }};
  for (const auto& file : options.places) {
    if (auto status = read_places(file, visitor); !status) return status;
  }
  if (is_empty) return bad_data(options.places.front().string() + ": expected places of objects, found none");
  return {};
}

}  // namespace cairn
