#include "runtime/paging/object_models.h"

#include <atomic>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace cairn {
namespace {

std::uint64_t bytes_of(const ObjectModel& model) {
  return sizeof model + model.vertices.capacity() * sizeof(ModelVertex) +
         model.indices.capacity() * sizeof(std::uint16_t) + model.levels.capacity() * sizeof(ModelLevel) +
         model.texture.texels.capacity() + model.billboard.texels.capacity();
}

}  // namespace

struct ObjectModels::Counters {
  std::atomic<std::size_t> resident = 0;
  std::atomic<std::uint64_t> bytes = 0;
  std::atomic<std::uint64_t> loads = 0;
};

ObjectModels::ObjectModels(std::shared_ptr<const PackReader> pack)
    : pack_(std::move(pack)), counters_(std::make_shared<Counters>()) {}

Result<std::shared_ptr<const ObjectModel>> ObjectModels::get(std::uint16_t number) {
  const std::lock_guard lock(mutex_);
  std::weak_ptr<const ObjectModel>& slot = models_[number];
  if (auto known = slot.lock()) return known;
  Result<ObjectModel> read = pack_->read_model(number);
  if (!read) return read.error();
  const std::uint64_t bytes = bytes_of(*read);
  const auto forget = [counters = counters_, bytes](const ObjectModel* model) {
    --counters->resident;
    counters->bytes -= bytes;
    delete model;
  };
  const std::shared_ptr<const ObjectModel> model(new ObjectModel(std::move(*read)), forget);
  ++counters_->resident;
  ++counters_->loads;
  counters_->bytes += bytes;
  slot = model;
  return model;
}

Result<LoadedTile> ObjectModels::complete(const IndexEntry& entry, LoadedTile tile) {
  if (entry.layer != Layer::objects || !tile.objects) return tile;
  std::set<std::uint16_t> used;
  for (const PlacedObject& object : tile.objects->objects) used.insert(object.model);
  const std::vector<std::uint16_t> numbers(used.begin(), used.end());
  std::vector<std::shared_ptr<const ObjectModel>> models;
  models.reserve(numbers.size());
  for (const std::uint16_t number : numbers) {
    Result<std::shared_ptr<const ObjectModel>> model = get(number);
    if (!model)
      return Error{model.error().code, "objects tile " + to_string(entry.id) + ": " + model.error().message};
    models.push_back(std::move(*model));
  }
  tile.standing = std::make_shared<const LoadedObjects>(entry.id, *tile.objects, numbers, std::move(models));
  tile.objects.reset();
  return tile;
}

ObjectModelCounts ObjectModels::counts() const {
  return {counters_->resident, counters_->bytes, counters_->loads};
}

TileSource with_models(TileSource source, std::shared_ptr<ObjectModels> models) {
  const auto complete = [models = std::move(models)](const IndexEntry& entry, Result<LoadedTile> tile) {
    return tile ? models->complete(entry, std::move(*tile)) : tile;
  };
  if (const ReadTile* read = std::get_if<ReadTile>(&source)) {
    return [read = *read, complete](const IndexEntry& entry) { return complete(entry, read(entry)); };
  }
  return [request = std::get<RequestTile>(source), complete](const IndexEntry& entry, std::stop_token stop,
                                                             TileDone done) {
    request(entry, std::move(stop), [entry, complete, done = std::move(done)](Result<LoadedTile> tile) {
      done(complete(entry, std::move(tile)));
    });
  };
}

}  // namespace cairn
