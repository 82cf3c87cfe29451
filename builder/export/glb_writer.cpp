#include "builder/export/glb_writer.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include <nlohmann/json.hpp>

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

// glTF 2.0, Khronos 2021: sections 3.6.2 and 4.4.
constexpr int kFloat = 5126, kUnsignedShort = 5123, kUnsignedInt = 5125;
constexpr int kVertices = 34962, kIndices = 34963;
constexpr std::size_t kMost16BitVertices = 65535;

template <class T>
void put(std::vector<std::byte>& out, T value) {
  std::array<std::byte, sizeof(T)> bytes;
  std::memcpy(bytes.data(), &value, sizeof(T));
  out.insert(out.end(), bytes.begin(), bytes.end());
}

Vector3 y_up(const Vector3& v) {
  return {v[0], v[2], -v[1]};
}

class GlbWriter {
 public:
  explicit GlbWriter(const GlbMesh& mesh) : mesh_(mesh) {}

  std::vector<std::byte> run() {
    Json attributes;
    attributes["POSITION"] = add_positions();
    attributes["NORMAL"] = add_normals();
    if (!mesh_.jpeg.empty()) attributes["TEXCOORD_0"] = add_texture();
    const std::size_t indices = add_indices();
    Json material = {{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}}};
    Json gltf = {{"asset", {{"version", "2.0"}, {"generator", "cairn " CAIRN_VERSION}}},
                 {"scene", 0},
                 {"scenes", Json::array({{{"nodes", Json::array({0})}}})},
                 {"nodes", Json::array({{{"mesh", 0}, {"translation", y_up(middle_)}}})}};
    if (!mesh_.about.empty()) gltf["asset"]["extras"] = Json::parse(mesh_.about);
    gltf["meshes"] =
        Json::array({{{"primitives",
                       Json::array({{{"attributes", attributes}, {"indices", indices}, {"material", 0}}})}}});
    if (!mesh_.jpeg.empty()) {
      gltf["images"] = Json::array({{{"bufferView", begin_view(0)}, {"mimeType", "image/jpeg"}}});
      buffer_.insert(buffer_.end(), mesh_.jpeg.begin(), mesh_.jpeg.end());
      end_view();
      constexpr int kClampToEdge = 33071, kLinear = 9729, kLinearMipmaps = 9987;
      gltf["samplers"] = Json::array({{{"magFilter", kLinear},
                                       {"minFilter", kLinearMipmaps},
                                       {"wrapS", kClampToEdge},
                                       {"wrapT", kClampToEdge}}});
      gltf["textures"] = Json::array({{{"source", 0}, {"sampler", 0}}});
      material["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
    }
    gltf["materials"] = Json::array({material});
    gltf["accessors"] = accessors_;
    gltf["bufferViews"] = views_;
    gltf["buffers"] = Json::array({{{"byteLength", buffer_.size()}}});
    return assemble(gltf.dump());
  }

 private:
  std::size_t begin_view(int target, int stride = 0) {
    while (buffer_.size() % 4 != 0) buffer_.push_back(std::byte{0});
    Json view = {{"buffer", 0}, {"byteOffset", buffer_.size()}, {"byteLength", 0}};
    if (stride != 0) view["byteStride"] = stride;
    if (target != 0) view["target"] = target;
    views_.push_back(view);
    return views_.size() - 1;
  }
  void end_view() {
    Json& view = views_.back();
    view["byteLength"] = buffer_.size() - view["byteOffset"].get<std::size_t>();
  }
  std::size_t add_accessor(std::size_t view, int type, const char* shape, std::size_t count) {
    accessors_.push_back({{"bufferView", view}, {"componentType", type}, {"count", count}, {"type", shape}});
    return accessors_.size() - 1;
  }

  std::size_t add_positions() {
    Vector3 low = mesh_.positions.front(), high = low;
    for (const Vector3& p : mesh_.positions) {
      for (std::size_t i = 0; i < 3; ++i) {
        low[i] = std::min(low[i], p[i]);
        high[i] = std::max(high[i], p[i]);
      }
    }
    for (std::size_t i = 0; i < 3; ++i) middle_[i] = (low[i] + high[i]) / 2;
    const std::size_t view = begin_view(kVertices);
    std::array<float, 3> least{}, most{};
    for (std::size_t n = 0; n < mesh_.positions.size(); ++n) {
      const Vector3& p = mesh_.positions[n];
      const Vector3 turned = y_up({p[0] - middle_[0], p[1] - middle_[1], p[2] - middle_[2]});
      for (std::size_t i = 0; i < 3; ++i) {
        const auto value = static_cast<float>(turned[i]);
        put(buffer_, value);
        least[i] = n == 0 ? value : std::min(least[i], value);
        most[i] = n == 0 ? value : std::max(most[i], value);
      }
    }
    end_view();
    const std::size_t accessor = add_accessor(view, kFloat, "VEC3", mesh_.positions.size());
    accessors_[accessor]["min"] = least;
    accessors_[accessor]["max"] = most;
    return accessor;
  }

  std::size_t add_normals() {
    const std::size_t view = begin_view(kVertices);
    for (const Vector3& normal : mesh_.normals)
      for (const double c : y_up(normal)) put(buffer_, static_cast<float>(c));
    end_view();
    return add_accessor(view, kFloat, "VEC3", mesh_.normals.size());
  }

  std::size_t add_texture() {
    const std::size_t view = begin_view(kVertices);
    for (const auto& place : mesh_.texture)
      for (const float c : place) put(buffer_, c);
    end_view();
    return add_accessor(view, kFloat, "VEC2", mesh_.texture.size());
  }

  std::size_t add_indices() {
    const bool wide = mesh_.positions.size() > kMost16BitVertices;
    const std::size_t view = begin_view(kIndices);
    for (const auto& triangle : mesh_.triangles) {
      for (const std::uint32_t i : triangle) {
        if (wide) {
          put(buffer_, i);
        } else {
          put(buffer_, static_cast<std::uint16_t>(i));
        }
      }
    }
    end_view();
    return add_accessor(view, wide ? kUnsignedInt : kUnsignedShort, "SCALAR", 3 * mesh_.triangles.size());
  }

  std::vector<std::byte> assemble(std::string json) const {
    while (json.size() % 4 != 0) json.push_back(' ');
    std::vector<std::byte> binary = buffer_;
    while (binary.size() % 4 != 0) binary.push_back(std::byte{0});
    std::vector<std::byte> out;
    constexpr std::uint32_t kMagic = 0x46546C67, kVersion = 2, kJson = 0x4E4F534A, kBinary = 0x004E4942;
    put(out, kMagic);
    put(out, kVersion);
    put(out, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + binary.size()));
    put(out, static_cast<std::uint32_t>(json.size()));
    put(out, kJson);
    for (const char c : json) put(out, c);
    put(out, static_cast<std::uint32_t>(binary.size()));
    put(out, kBinary);
    out.insert(out.end(), binary.begin(), binary.end());
    return out;
  }

  const GlbMesh& mesh_;
  Vector3 middle_{};
  std::vector<std::byte> buffer_;
  Json views_ = Json::array();
  Json accessors_ = Json::array();
};

}  // namespace

std::vector<std::byte> encode_glb(const GlbMesh& mesh) {
  return GlbWriter(mesh).run();
}

}  // namespace cairn
