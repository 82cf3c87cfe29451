#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include <nlohmann/json.hpp>

#include "builder/bake/bake_session.h"
#include "builder/pack/unit_keys.h"
#include "cairn/pack_layout.h"
#include "cairn/status.h"

namespace cairn {

/// What is kept of a bake beside its pack, PACK.units: the journal with a record for each unit, and what each
/// was made of. By it a later bake knows which units it can take from the pack. It may be removed.
struct KeptUnits {
  struct Source {
    std::filesystem::path path;
    std::uint64_t hash = 0;
    bool has_voids = false;  ///< or may have: of DEMs
  };
  PackId pack{};  ///< whose units they are
  nlohmann::json options;
  bool allow_error = false;
  std::vector<Source> dems;
  std::vector<Source> images;
  std::optional<Source> geoid;
  std::vector<Source> places;    ///< files of places of objects
  std::filesystem::path models;  ///< the folder of their models
  std::vector<Source> model_files;
  UnitKeys keys;
  std::vector<RecordPlace> heights;  ///< the records of keys.heights, in their order
  std::vector<RecordPlace> imagery;  ///< likewise
};

/// Makes PACK.units of the journal of a session whose pack is finished.
Status keep_units(BakeSession& session, const BakePlan& layers, const BuildOptions& options,
                  const std::vector<std::uint64_t>& hashes);

/// Reads PACK.units. nullopt where there is none, or where it is damaged or another pack's: then all units
/// have to be made again.
std::optional<KeptUnits> read_kept_units(const std::filesystem::path& pack);

}  // namespace cairn
