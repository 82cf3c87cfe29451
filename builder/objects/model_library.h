#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "builder/objects/model_stream.h"
#include "cairn/object_model.h"
#include "cairn/status.h"

namespace cairn {

/// The models of a folder, by name. One is read when it is first asked for.
///
/// NAME.gltf, .glb, .obj, .dxf and what else assimp reads is a model of triangles; NAME.WxH.png (.jpg, .tga,
/// .bmp), W and H in metres, one of an image. Not thread-safe.
class ModelLibrary {
 public:
  /// The error is usage where there is no such folder, or two files are one model.
  static Result<ModelLibrary> open(const std::filesystem::path& folder);

  /// Returns the model's place in the order of all names; an error with the names that there are.
  Result<std::size_t> find(std::string_view name) const;

  /// A model as it is stored.
  struct Model {
    std::string name;
    float size_m = 0;
    std::size_t triangles = 0;
    std::size_t vertices = 0;
    std::size_t levels = 0;
    std::vector<std::byte> block;
  };
  /// Reads the model if it has not been read. REQUIRES: a place that find() returned.
  Result<const Model*> load(std::size_t place);

  /// Returns the models that have been read, with their places, in order.
  std::vector<std::pair<std::size_t, const Model*>> loaded() const;
  std::size_t size() const { return candidates_.size(); }  ///< of all names

 private:
  struct Candidate {
    std::string name;
    std::filesystem::path file;
    double width_m = 0;  ///< of an image; 0 for triangles
    double height_m = 0;
  };
  static std::optional<Candidate> candidate_of(const std::filesystem::path& file);

  std::filesystem::path folder_;
  std::vector<Candidate> candidates_;  // by name
  std::vector<std::optional<Model>> models_;
};

/// Every file in a folder of models, and in the folders in it: what decides the bytes of the models.
std::vector<std::filesystem::path> files_of_models(const std::filesystem::path& folder);

/// Makes a model of a file's mesh. The error is bad_data where it has nothing to draw.
Result<ObjectModel> make_model(const std::string& name, SourceMesh mesh);

}  // namespace cairn
