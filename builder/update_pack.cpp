#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "builder/bake/bake_target.h"
#include "builder/bake/fingerprint.h"
#include "builder/bake/layer_bake.h"
#include "builder/bake/memory_budget.h"
#include "builder/bake/output_check.h"
#include "builder/bake/thread_arena.h"
#include "builder/pack/kept_units.h"
#include "builder/pack/make_pack.h"
#include "builder/pack/options_json.h"
#include "cairn/pack_reader.h"
#include "cairn/update.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using Sources = std::vector<KeptUnits::Source>;

/// The pack before the update, as far as it is known.
struct OldPack {
  PackReader reader;
  std::optional<KeptUnits> kept;
  std::optional<JournalReader> records;  ///< of the kept units
  nlohmann::json options;
  bool allow_error = false;
  Sources dems;    ///< all, or without the kept units the names that the pack states
  Sources images;  ///< likewise
  Sources places;  ///< likewise; none without the kept units
};

// What the pack itself says of its sources: names and hashes.
Sources named_sources(const nlohmann::json& list) {
  Sources sources;
  for (const auto& source : list)
    sources.push_back({source.at("name").get<std::string>(),
                       std::stoull(source.at("xxh3").get<std::string>(), nullptr, 16), true});
  return sources;
}

Result<OldPack> open_old(const fs::path& path) {
  auto reader = PackReader::open(path);
  if (!reader) return reader.error();
  OldPack old{std::move(*reader), read_kept_units(path), std::nullopt, {}, false, {}, {}, {}};
  if (old.kept) {
    auto records = JournalReader::open(units_path(path));
    if (!records) return records.error();
    old.records = std::move(*records);
    old.options = old.kept->options;
    old.allow_error = old.kept->allow_error;
    old.dems = old.kept->dems;
    old.images = old.kept->images;
    old.places = old.kept->places;
    return old;
  }
  const auto metadata = nlohmann::json::parse(old.reader.metadata_json(), nullptr, false);
  try {
    old.options = metadata.at("options");
    old.dems = named_sources(metadata.at("sources"));
    if (metadata.contains("imagery")) old.images = named_sources(metadata.at("imagery").at("sources"));
    if (metadata.contains("accuracy")) old.allow_error = metadata.at("accuracy").contains("excess");
  } catch (const std::exception& error) {
    return bad_data(path.string() + ": metadata: " + error.what());
  }
  return old;
}

/// The new set of one kind of inputs.
class NewSet {
 public:
  NewSet(const Sources& old, const std::vector<fs::path>& given) : old_(old), given_(given) {}

  // Takes the path of a source of the pack by its path or the file's name; false where it is none's.
  bool remove(const fs::path& file) {
    const auto found = find(file);
    if (!found) return false;
    removed_.push_back(*found);
    return true;
  }

  Status collect(std::vector<fs::path>& out, std::vector<UpdateReport::Change>& changes) const;

 private:
  std::optional<std::size_t> find(const fs::path& file) const {
    for (std::size_t s = 0; s < old_.size(); ++s)
      if (is_same_file(old_[s].path, file)) return s;
    for (std::size_t s = 0; s < old_.size(); ++s)
      if (old_[s].path.filename() == file.filename()) return s;
    return std::nullopt;
  }
  bool is_removed(std::size_t s) const {
    return std::find(removed_.begin(), removed_.end(), s) != removed_.end();
  }

  const Sources& old_;
  const std::vector<fs::path>& given_;
  std::vector<std::size_t> removed_;
};

Status NewSet::collect(std::vector<fs::path>& out, std::vector<UpdateReport::Change>& changes) const {
  std::map<std::size_t, fs::path> in_place;  // of the old ones
  std::vector<fs::path> added;
  for (const fs::path& file : given_) {
    const auto place = find(file);
    if (!place || is_removed(*place)) {
      added.push_back(file);
    } else if (!in_place.emplace(*place, file).second && !is_same_file(in_place[*place], file)) {
      return usage_error(file.string() + ": expected one file of this name, found " +
                         in_place[*place].string() + " too");
    }
  }
  for (const std::size_t s : removed_) changes.push_back({"removed", old_[s].path});
  bool whole = true;
  std::vector<fs::path> kept;
  for (std::size_t s = 0; s < old_.size(); ++s) {
    if (is_removed(s)) continue;
    const auto replaced = in_place.find(s);
    whole = whole && replaced != in_place.end();
    const fs::path& path = replaced != in_place.end() ? replaced->second : old_[s].path;
    std::error_code ignored;
    if (!fs::exists(path, ignored))
      return failed(path.string() +
                    ": expected the source of the pack where it was, or among the inputs, or to be "
                    "removed, found none");
    kept.push_back(path);
  }
  for (const fs::path& file : added) changes.push_back({"added", file});
  out = whole ? given_ : kept;
  if (!whole) out.insert(out.end(), added.begin(), added.end());
  return {};
}

// The metadata names the files of objects, but not which of them is of places, nor the models' folder.
Status use_models(const UpdateOptions& asked, const OldPack& old, ObjectOptions& objects) {
  const std::string name = asked.pack.string();
  if (!old.kept && asked.places.empty() && old.reader.levels(Layer::objects))
    return failed(name + ": expected " + units_path(asked.pack).string() +
                  ", which names the files of its objects, found none of this pack, and no new ones");
  if (objects.places.empty()) return {};
  objects.models = asked.models;
  if (objects.models.empty() && old.kept) objects.models = old.kept->models;
  if (!objects.models.empty()) return {};
  return usage_error(name + ": models: expected the folder of the objects' models, found none");
}

Result<BuildOptions> new_options(const UpdateOptions& asked, const OldPack& old, UpdateReport& report) {
  auto options = from_json(old.options);
  if (!options) return options.error();
  NewSet dems(old.dems, asked.dems), images(old.images, asked.images), places(old.places, asked.places);
  for (const fs::path& file : asked.removed) {
    if (!dems.remove(file) && !images.remove(file) && !places.remove(file))
      return usage_error(file.string() +
                         ": expected a source of the pack to remove, found none of this name");
  }
  if (auto status = dems.collect(options->mosaic.inputs, report.changes); !status) return status.error();
  if (auto status = images.collect(options->imagery.inputs, report.changes); !status) return status.error();
  if (auto status = places.collect(options->objects.places, report.changes); !status) return status.error();
  if (auto status = use_models(asked, old, options->objects); !status) return status.error();
  if (old.kept && old.kept->geoid) options->mosaic.geoid = old.kept->geoid->path;
  if (!old.kept && old.options.value("geoid", false))
    return failed(asked.pack.string() + ": expected " + units_path(asked.pack).string() +
                  ", which names the geoid, found none of this pack");
  if (options->mosaic.inputs.empty() && options->imagery.inputs.empty())
    return usage_error("update: expected an input that is left, found none");
  options->heights.allow_error = old.allow_error;
  options->session = asked.session;
  options->session.force = true;
  if (is_same_file(asked.pack, asked.session.target)) return options;
  options->session.force = asked.session.force;
  return options;
}

const KeptUnits::Source* source_of_hash(const Sources& sources, std::uint64_t hash) {
  const auto found =
      std::find_if(sources.begin(), sources.end(), [&](const auto& source) { return source.hash == hash; });
  return found == sources.end() ? nullptr : &*found;
}

void note_changes(const OldPack& old, const BuildOptions& options, const std::vector<std::uint64_t>& hashes,
                  std::vector<UpdateReport::Change>& changes) {
  const auto note = [&](const std::vector<fs::path>& files, const Sources& sources, std::size_t first) {
    for (std::size_t f = 0; f < files.size(); ++f) {
      const bool is_added = std::any_of(changes.begin(), changes.end(), [&](const auto& change) {
        return change.what == "added" && change.path == files[f];
      });
      if (!is_added && source_of_hash(sources, hashes[first + f]) == nullptr)
        changes.push_back({"changed", files[f]});
    }
  };
  note(options.mosaic.inputs, old.dems, 0);
  const std::size_t images = options.mosaic.inputs.size();
  note(options.imagery.inputs, old.images, images);
  if (options.objects.places.empty()) return;
  const std::size_t places = images + options.imagery.inputs.size() + (options.mosaic.geoid ? 1 : 0);
  note(options.objects.places, old.places, places);
  const std::vector<fs::path> files = files_of(options);
  const std::size_t models = places + options.objects.places.size();
  if (old.kept)
    note({files.begin() + static_cast<std::ptrdiff_t>(models), files.end()}, old.kept->model_files, models);
}

/// Finds the units of the old pack that have the keys of the new one.
class UnitFinder {
 public:
  UnitFinder(const std::vector<UnitKey>& old_keys, const std::vector<RecordPlace>& places,
             const std::vector<UnitKey>& new_keys) {
    std::map<TileId, std::size_t> old_by_unit;
    for (std::size_t u = 0; u < old_keys.size(); ++u) old_by_unit.emplace(old_keys[u].unit, u);
    for (const UnitKey& key : new_keys) {
      const auto old = old_by_unit.find(key.unit);
      if (old == old_by_unit.end() || old_keys[old->second].hash != key.hash) continue;
      found_.emplace(key.unit, Found{places[old->second], &old_keys[old->second].sources, &key.sources});
    }
  }

  struct Found {
    RecordPlace place;
    const std::vector<std::uint32_t>* old_sources;
    const std::vector<std::uint32_t>* new_sources;
  };
  const Found* find(const TileId& unit) const {
    const auto found = found_.find(unit);
    return found == found_.end() ? nullptr : &found->second;
  }
  std::uint64_t count() const { return found_.size(); }

 private:
  std::map<TileId, Found> found_;
};

// Sources have other numbers in another set of inputs.
std::vector<std::uint64_t> renumbered(const std::vector<std::uint64_t>& counts,
                                      const UnitFinder::Found& found) {
  std::vector<std::uint64_t> out;
  for (std::size_t i = 0; i < found.old_sources->size(); ++i) {
    const std::size_t from = (*found.old_sources)[i], to = (*found.new_sources)[i];
    if (from >= counts.size() || counts[from] == 0) continue;
    out.resize(std::max(out.size(), to + 1));
    out[to] = counts[from];
  }
  return out;
}

void renumber(const UnitFinder::Found& found, HeightNode& node) {
  node.posts_used = renumbered(node.posts_used, found);
  node.posts_lost = renumbered(node.posts_lost, found);
}

void renumber(const UnitFinder::Found&, TextureNode&) {}

bool lies_in(const TileId& id, const TileId& unit) {
  return id.level > unit.level && ancestor_of(id, unit.level) == unit;
}

/// A unit's result again, from the old pack and its kept record.
template <TileLayer L>
Result<UnitResult<L>> taken_unit(const L& layer, const TileTree& tree, const TileId& unit,
                                 const UnitFinder::Found& found, const OldPack& old) {
  const auto record = old.records->read(found.place);
  if (!record) return record.error();
  UnitResult<L> result;
  result.root_block = record->held;
  for (const IndexEntry& entry : record->entries) {
    const bool is_root = entry.id == unit;
    if (!is_root && !lies_in(entry.id, unit)) continue;
    TileBlock tile{entry, {}};
    if (entry.bytes > 0) {
      auto block = old.reader.read_block(entry);
      if (!block) return block.error();
      tile.block = std::move(*block);
    }
    if (is_root) {
      result.root_block = std::move(tile);
    } else {
      result.blocks.push_back(std::move(tile));
    }
  }
  ByteReader reader(record->root);
  auto node = layer.load_state(reader);
  if (!node) return node.error();
  renumber(found, *node);
  result.root = std::move(*node);
  result.leaves = tree.leaves(unit).size();
  return result;
}

Result<UpdateReport> update_in_arena(const UpdateOptions& asked, int threads,
                                     const ProgressCallback& progress) {
  const auto start = std::chrono::steady_clock::now();

  // 1. The pack, what it was made of, and what it will be made of.
  const auto old = open_old(asked.pack);
  if (!old) return old.error();
  UpdateReport report;
  report.knows_units = old->kept.has_value();
  auto options = new_options(asked, *old, report);
  if (!options) return options.error();
  const BakeIdentity identity = identity_of(*options);
  if (!asked.dry_run) {
    if (auto status = check_target(options->session, identity.inputs); !status) return status.error();
  }
  const auto layers = plan_bake(*options, threads);
  if (!layers) return layers.error();
  const auto hashes = hash_files(identity.inputs);
  if (!hashes) return hashes.error();
  note_changes(*old, *options, *hashes, report.changes);
  if (layers->heights) {
    for (std::size_t s = 0; s < layers->heights->pool().size(); ++s) {
      const KeptUnits::Source* source = source_of_hash(old->dems, (*hashes)[s]);
      if (source != nullptr && source->has_voids) layers->heights->pool().expect_voids(s);
    }
  }

  // 2. Which units stay as they are.
  const UnitKeys keys = unit_keys(*layers, *options, *hashes);
  const KeptUnits none;
  const KeptUnits& kept = old->kept ? *old->kept : none;
  const UnitFinder heights(kept.keys.heights, kept.heights, keys.heights);
  const UnitFinder imagery(kept.keys.imagery, kept.imagery, keys.imagery);
  report.taken_units = heights.count() + imagery.count();
  report.made_units = keys.heights.size() + keys.imagery.size() - report.taken_units;
  report.options = *options;
  if (asked.dry_run) return report;

  // 3. As a full bake, but for those units.
  auto session = begin_session(options->session, identity, header_for(*layers, *options));
  if (!session) return session.error();
  session->input_hashes = *hashes;
  InputHashing hashing(*session);
  const auto bake = [&](auto& layer, const TileTree& tree, Progress& now, const UnitFinder& taken) {
    const auto make = [&](const TileId& unit) {
      const UnitFinder::Found* found = taken.find(unit);
      return found != nullptr ? taken_unit(layer, tree, unit, *found, *old) : bake_unit(layer, tree, unit);
    };
    return bake_layer_by(make, layer, tree, samples_per_leaf(options->grid.tile_size), threads, *session, now,
                         progress);
  };
  const LayerMakers makers{[&](HeightLayer& layer, const TileTree& tree, Progress& now) {
                             return bake(layer, tree, now, heights);
                           },
                           [&](ImageryLayer& layer, const TileTree& tree, Progress& now) {
                             return bake(layer, tree, now, imagery);
                           }};
  auto built = make_pack(
      *layers, *options, threads, *session, makers, [&hashing] { return hashing.hashes(); }, progress);
  if (!built) return end_failed_bake(*session, hashing, built.error());
  if (auto units = keep_units(*session, *layers, *options, *hashes); !units && built->warning.empty())
    built->warning = units.error().message;
  report.build = std::move(*built);
  report.build.resumed = session->resumed;
  report.build.threads = threads;
  report.build.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace

Result<UpdateReport> update_pack(const UpdateOptions& options, const ProgressCallback& progress) {
  keep_freed_memory();
  return with_threads(options.session.threads,
                      [&](int threads) { return update_in_arena(options, threads, progress); });
}

}  // namespace cairn
