#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "builder/export/geodesy.h"
#include "cairn/object_model.h"

namespace cairn {

/// What of a model all files share: the bytes of its vertices and triangles, and what they have to say of
/// them. y is up, as in glTF, and −z points north.
struct ModelBuffer {
  std::uint32_t number = 0;
  std::string name;
  std::vector<std::byte> bytes;
  std::size_t vertices = 0;
  std::size_t indices = 0;
  std::array<float, 3> low{};
  std::array<float, 3> high{};
};

/// Returns a model's finest level. A model of an image becomes two upright pictures that cross.
ModelBuffer model_buffer(std::uint32_t number, const ObjectModel& model);

/// One object: geocentric metres of its foot, and how it stands there.
struct Instance {
  Vector3 foot_m{};
  LonLat place;
  double heading_degrees = 0;
  double scale = 1;
};

/// The instances of one model.
struct ModelInstances {
  const ModelBuffer* model = nullptr;
  std::vector<Instance> instances;
};

/// Returns a binary glTF 2.0 file that draws the instances (EXT_mesh_gpu_instancing). Vertices and textures
/// are in FOLDER/NUMBER.bin and FOLDER/NUMBER.png. REQUIRES: an instance of each model, one model at least.
std::vector<std::byte> encode_instances_glb(const std::vector<ModelInstances>& models,
                                            const std::string& folder);

}  // namespace cairn
