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
  std::uint64_t places = 0;
  const auto take = [&](const ObjectPlace& place) -> Status {
    ++places;
    if (place.model == last) return {};
    const auto found = library->find(place.model);
    if (!found) return found.error();
    const auto model = library->load(*found);
    if (!model) return model.error();
    last = place.model;
    return {};
  };
  for (const auto& file : options.places) {
    if (auto status = read_places(file, take); !status) return status;
  }
  if (places == 0)
    return bad_data(options.places.front().string() + ": expected places of objects, found none");
  return {};
}

}  // namespace cairn
