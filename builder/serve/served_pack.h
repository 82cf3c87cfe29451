#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include <sys/stat.h>

#include "builder/export/metre_tiles.h"
#include "builder/export/pack_patches.h"
#include "builder/export/quantized_mesh_plan.h"
#include "builder/export/vertical_shift.h"
#include "builder/serve/file_answer.h"
#include "cairn/pack_reader.h"

namespace cairn {

/// One state of a pack's file. Any number of threads may use it.
struct OpenedPack {
  OpenedPack(PackReader r, ServedFile f);

  PackReader reader;
  ServedFile served;                   ///< the file that the reader reads
  std::optional<PackPatches> patches;  ///< where the pack has heights
  mutable MetreTiles tiles;
  /// What makes heights those above the ellipsoid, which CesiumJS draws; nothing where the pack's datum is
  /// unknown or no geoid is installed: heights are then as stored.
  VerticalShift shift;
  std::optional<QuantizedMeshPlan> meshes;  ///< where tiles can be made of the pack's heights
};

/// A pack that is served under its file's name. Where the file is replaced, the new one is opened, and
/// answers that have begun go on with the old one.
class ServedPack {
 public:
  static Result<ServedPack> open(const std::filesystem::path& path);

  const std::string& name() const { return name_; }
  const std::filesystem::path& path() const { return path_; }

  /// Returns the pack as it is now. The error says why the file that is there now does not open; a file that
  /// is gone is served until there is another.
  Result<std::shared_ptr<const OpenedPack>> now() const;

 private:
  ServedPack(std::filesystem::path path, struct stat state, std::shared_ptr<const OpenedPack> opened);

  struct Current {
    std::mutex mutex;
    struct stat state;
    std::shared_ptr<const OpenedPack> opened;
  };
  std::filesystem::path path_;
  std::string name_;
  std::unique_ptr<Current> current_;
};

}  // namespace cairn
