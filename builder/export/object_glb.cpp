#include "builder/export/object_glb.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include <nlohmann/json.hpp>

namespace cairn {
namespace {

using GlbJson = nlohmann::ordered_json;

constexpr int kFloats = 5126, kShorts = 5123;
constexpr int kVertexTarget = 34962, kIndexTarget = 34963;
constexpr std::size_t kVertexFloats = 8;  // position, normal, texture

template <class T>
void append_value(std::vector<std::byte>& out, T value) {
  std::array<std::byte, sizeof(T)> bytes;
  std::memcpy(bytes.data(), &value, sizeof(T));
  out.insert(out.end(), bytes.begin(), bytes.end());
}

Vector3 with_y_up(const Vector3& v) {
  return {v[0], v[2], -v[1]};
}

/// Two pictures as wide and high as the model's, one from west to east and one from south to north.
void cross_pictures(const ObjectModel& model, std::vector<ModelVertex>& vertices,
                    std::vector<std::uint16_t>& indices) {
  for (const bool turned : {false, true}) {
    const auto first = static_cast<std::uint16_t>(vertices.size());
    for (const auto& [side, up] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
      const float across = side == 1 ? model.radius_m : -model.radius_m;
      ModelVertex vertex;
      vertex.position_m = {turned ? 0 : across, turned ? across : 0, up == 1 ? model.top_m : model.bottom_m};
      vertex.normal = {0, 0, 1};
      vertex.texture = {static_cast<float>(side), static_cast<float>(1 - up)};
      vertices.push_back(vertex);
    }
    for (const int i : {0, 1, 2, 0, 2, 3}) indices.push_back(static_cast<std::uint16_t>(first + i));
  }
}

/// The rotation of columns x, y and z as a unit quaternion (x, y, z, w): of the four ways to divide the one
/// by the largest component (Shepperd 1978).
std::array<double, 4> quaternion_of(const Vector3& x, const Vector3& y, const Vector3& z) {
  const double trace = x[0] + y[1] + z[2];
  std::array<double, 4> q{1 + 2 * x[0] - trace, 1 + 2 * y[1] - trace, 1 + 2 * z[2] - trace, 1 + trace};
  switch (std::max_element(q.begin(), q.end()) - q.begin()) {
    case 0:
      q = {q[0], x[1] + y[0], z[0] + x[2], y[2] - z[1]};
      break;
    case 1:
      q = {x[1] + y[0], q[1], y[2] + z[1], z[0] - x[2]};
      break;
    case 2:
      q = {z[0] + x[2], y[2] + z[1], q[2], x[1] - y[0]};
      break;
    default:
      q = {y[2] - z[1], z[0] - x[2], x[1] - y[0], q[3]};
  }
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (double& part : q) part /= length;
  return q;
}

/// How the model's axes, which are right, up and back in glTF, lie at the object's place.
std::array<double, 4> rotation_of(const Instance& instance) {
  const LocalAxes axes = local_axes(instance.place);
  const double heading = instance.heading_degrees * (std::numbers::pi / 180);
  const double s = std::sin(heading), c = std::cos(heading);
  Vector3 right{}, back{};
  for (std::size_t i = 0; i < 3; ++i) {
    right[i] = c * axes.east[i] - s * axes.north[i];
    back[i] = -(s * axes.east[i] + c * axes.north[i]);
  }
  return quaternion_of(with_y_up(right), with_y_up(axes.up), with_y_up(back));
}

class InstanceWriter {
 public:
  InstanceWriter(const std::vector<ModelInstances>& models, const std::string& folder)
      : models_(models), folder_(folder), middle_(models.front().instances.front().foot_m) {}

  std::vector<std::byte> run() {
    GlbJson nodes = GlbJson::array(), numbers = GlbJson::array();
    buffers_.push_back({{"byteLength", 0}});
    for (std::size_t m = 0; m < models_.size(); ++m) {
      add_mesh(*models_[m].model);
      nodes.push_back(
          {{"name", models_[m].model->name},
           {"mesh", m},
           {"translation", with_y_up(middle_)},
           {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", attributes_of(models_[m])}}}}}});
      numbers.push_back(m);
    }
    buffers_[0]["byteLength"] = binary_.size();
    constexpr int kClampToEdge = 33071, kLinear = 9729, kLinearMipmaps = 9987;
    const GlbJson sampler = {{"magFilter", kLinear},
                             {"minFilter", kLinearMipmaps},
                             {"wrapS", kClampToEdge},
                             {"wrapT", kClampToEdge}};
    const GlbJson gltf = {{"asset", {{"version", "2.0"}, {"generator", "cairn " CAIRN_VERSION}}},
                          {"extensionsUsed", GlbJson::array({"EXT_mesh_gpu_instancing"})},
                          {"extensionsRequired", GlbJson::array({"EXT_mesh_gpu_instancing"})},
                          {"scene", 0},
                          {"scenes", GlbJson::array({{{"nodes", numbers}}})},
                          {"nodes", nodes},
                          {"meshes", meshes_},
                          {"materials", materials_},
                          {"textures", textures_},
                          {"images", images_},
                          {"samplers", GlbJson::array({sampler})},
                          {"accessors", accessors_},
                          {"bufferViews", views_},
                          {"buffers", buffers_}};
    return assemble(gltf.dump(-1, ' ', false, GlbJson::error_handler_t::replace));
  }

 private:
  std::size_t add_view(std::size_t buffer, std::size_t offset, std::size_t bytes, int target) {
    GlbJson view = {{"buffer", buffer}, {"byteOffset", offset}, {"byteLength", bytes}};
    if (target == kVertexTarget) view["byteStride"] = kVertexFloats * sizeof(float);
    if (target != 0) view["target"] = target;
    views_.push_back(view);
    return views_.size() - 1;
  }
  std::size_t add_accessor(std::size_t view, std::size_t offset, int type, const char* shape,
                           std::size_t count) {
    accessors_.push_back({{"bufferView", view},
                          {"byteOffset", offset},
                          {"componentType", type},
                          {"count", count},
                          {"type", shape}});
    return accessors_.size() - 1;
  }

  void add_mesh(const ModelBuffer& model) {
    const std::string file = folder_ + "/" + std::to_string(model.number);
    buffers_.push_back({{"uri", file + ".bin"}, {"byteLength", model.bytes.size()}});
    const std::size_t buffer = buffers_.size() - 1,
                      vertex_bytes = model.vertices * kVertexFloats * sizeof(float);
    const std::size_t vertices = add_view(buffer, 0, vertex_bytes, kVertexTarget);
    const std::size_t indices =
        add_view(buffer, vertex_bytes, model.indices * sizeof(std::uint16_t), kIndexTarget);
    const std::size_t position = add_accessor(vertices, 0, kFloats, "VEC3", model.vertices);
    accessors_[position]["min"] = model.low;
    accessors_[position]["max"] = model.high;
    const std::size_t normal = add_accessor(vertices, 12, kFloats, "VEC3", model.vertices);
    const std::size_t texture = add_accessor(vertices, 24, kFloats, "VEC2", model.vertices);
    const std::size_t corners = add_accessor(indices, 0, kShorts, "SCALAR", model.indices);
    const std::size_t material = materials_.size();
    images_.push_back({{"uri", file + ".png"}});
    textures_.push_back({{"source", material}, {"sampler", 0}});
    materials_.push_back(
        {{"pbrMetallicRoughness",
          {{"baseColorTexture", {{"index", material}}}, {"metallicFactor", 0}, {"roughnessFactor", 1}}},
         {"alphaMode", "MASK"},
         {"doubleSided", true}});
    meshes_.push_back(
        {{"name", model.name},
         {"primitives",
          GlbJson::array(
              {{{"attributes", {{"POSITION", position}, {"NORMAL", normal}, {"TEXCOORD_0", texture}}},
                {"indices", corners},
                {"material", material}}})}});
  }

  template <std::size_t kParts, class PartsOf>
  std::size_t add_attribute(const ModelInstances& model, const char* shape, const PartsOf& parts_of) {
    const std::size_t begin = binary_.size();
    for (const Instance& instance : model.instances) {
      const std::array<double, kParts> parts = parts_of(instance);
      for (const double part : parts) append_value(binary_, static_cast<float>(part));
    }
    return add_accessor(add_view(0, begin, binary_.size() - begin, 0), 0, kFloats, shape,
                        model.instances.size());
  }

  GlbJson attributes_of(const ModelInstances& model) {
    const auto place = add_attribute<3>(model, "VEC3", [this](const Instance& i) {
      return with_y_up({i.foot_m[0] - middle_[0], i.foot_m[1] - middle_[1], i.foot_m[2] - middle_[2]});
    });
    const auto turn = add_attribute<4>(model, "VEC4", rotation_of);
    const auto size = add_attribute<3>(model, "VEC3", [](const Instance& i) {
      return Vector3{i.scale, i.scale, i.scale};
    });
    return {{"TRANSLATION", place}, {"ROTATION", turn}, {"SCALE", size}};
  }

  std::vector<std::byte> assemble(std::string json) const {
    while (json.size() % 4 != 0) json.push_back(' ');
    constexpr std::uint32_t kMagic = 0x46546C67, kVersion = 2, kJson = 0x4E4F534A, kBinary = 0x004E4942;
    std::vector<std::byte> out;
    append_value(out, kMagic);
    append_value(out, kVersion);
    append_value(out, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + binary_.size()));
    append_value(out, static_cast<std::uint32_t>(json.size()));
    append_value(out, kJson);
    for (const char c : json) append_value(out, c);
    append_value(out, static_cast<std::uint32_t>(binary_.size()));
    append_value(out, kBinary);
    out.insert(out.end(), binary_.begin(), binary_.end());
    return out;
  }

  const std::vector<ModelInstances>& models_;
  const std::string& folder_;
  Vector3 middle_;
  std::vector<std::byte> binary_;
  GlbJson buffers_ = GlbJson::array(), views_ = GlbJson::array(), accessors_ = GlbJson::array();
  GlbJson meshes_ = GlbJson::array(), materials_ = GlbJson::array();
  GlbJson textures_ = GlbJson::array(), images_ = GlbJson::array();
};

}  // namespace

ModelBuffer model_buffer(std::uint32_t number, const ObjectModel& model) {
  std::vector<ModelVertex> vertices = model.vertices;
  std::vector<std::uint16_t> indices;
  if (model.levels.empty()) {
    cross_pictures(model, vertices, indices);
  } else {
    const auto first = model.indices.begin() + model.levels[0].first;
    indices.assign(first, first + model.levels[0].count);
  }
  ModelBuffer buffer{number, model.name, {}, vertices.size(), indices.size(), {}, {}};
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const auto& [x, y, z] = vertices[v].position_m;
    const std::array<float, 3> position{x, z, -y};
    const auto& [nx, ny, nz] = vertices[v].normal;
    for (const float part : position) append_value(buffer.bytes, part);
    for (const float part : {nx, nz, -ny}) append_value(buffer.bytes, part);
    for (const float part : vertices[v].texture) append_value(buffer.bytes, part);
    for (std::size_t i = 0; i < 3; ++i) {
      buffer.low[i] = v == 0 ? position[i] : std::min(buffer.low[i], position[i]);
      buffer.high[i] = v == 0 ? position[i] : std::max(buffer.high[i], position[i]);
    }
  }
  for (const std::uint16_t index : indices) append_value(buffer.bytes, index);
  return buffer;
}

std::vector<std::byte> encode_instances_glb(const std::vector<ModelInstances>& models,
                                            const std::string& folder) {
  return InstanceWriter(models, folder).run();
}

}  // namespace cairn
