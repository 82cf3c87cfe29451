// The program cairn-model: reads a model or an image and writes it to standard output as encode_mesh() does.
// It is a process of its own, with limits, since a hostile file may make a library of formats crash or grow.

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <sys/resource.h>

#include "builder/objects/model_stream.h"
#include "builder/objects/reader/decode_image.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr rlim_t kMemory = rlim_t{4} << 30;
constexpr rlim_t kSeconds = 60;
constexpr float kSmoothDegrees = 50;  // between triangles that share a normal, where the file has none

void set_limits() {
  const auto limit = [](auto what, rlim_t value) {
    const rlimit both{value, value};
    ::setrlimit(what, &both);
  };
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, kSeconds);
#ifndef __SANITIZE_ADDRESS__
  limit(RLIMIT_AS, kMemory);
#endif
}

std::string lower_extension(const fs::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

/// Formats whose models usually have z upwards; the others have y.
bool has_z_up(const fs::path& file) {
  const std::string extension = lower_extension(file);
  for (const char* known : {".dxf", ".3ds", ".stl", ".ply", ".off"})
    if (extension == known) return true;
  return false;
}

std::array<float, 3> turned(const aiVector3D& v, bool z_up) {
  return z_up ? std::array{v.x, v.y, v.z} : std::array{v.x, -v.z, v.y};
}

std::uint8_t code_of(float colour) {
  const float c = colour > 0 ? std::min(colour, 1.0f) : 0.0f;
  return static_cast<std::uint8_t>(std::lround(c * 255));
}

/// IEC 61966-2-1.
float srgb_of_linear(float c) {
  return c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1 / 2.4f) - 0.055f;
}

/// glTF says the factors of colours in linear light, the others as they are seen.
bool has_linear_colours(const fs::path& file) {
  const std::string extension = lower_extension(file);
  return extension == ".gltf" || extension == ".glb";
}

/// The pictures of a scene, each once.
class Pictures {
 public:
  Pictures(const aiScene& scene, fs::path folder, SourceMesh& mesh)
      : scene_(scene), folder_(std::move(folder)), mesh_(mesh) {}

  Result<std::uint32_t> take(const std::string& name) {
    if (const auto known = numbers_.find(name); known != numbers_.end()) return known->second;
    auto image = read(name);
    if (!image) return image.error();
    const auto number = static_cast<std::uint32_t>(mesh_.images.size());
    mesh_.images.push_back(std::move(*image));
    numbers_.emplace(name, number);
    return number;
  }

 private:
  Result<SourceMesh::Image> read(const std::string& name) const {
    if (const aiTexture* embedded = scene_.GetEmbeddedTexture(name.c_str()))
      return read_embedded(*embedded, name);
    std::string relative = name;
    for (char& c : relative)
      if (c == '\\') c = '/';
    fs::path file = folder_ / relative;
    std::error_code ignored;
    if (!fs::exists(file, ignored)) file = folder_ / fs::path(relative).filename();
    if (!fs::exists(file, ignored))
      return bad_data("texture " + name + ": expected an image beside the model, found none");
    return decode_image_file(file);
  }

  static Result<SourceMesh::Image> read_embedded(const aiTexture& texture, const std::string& name) {
    if (texture.mHeight == 0)
      return decode_image({reinterpret_cast<const std::byte*>(texture.pcData), texture.mWidth},
                          "texture " + name);
    SourceMesh::Image image{texture.mWidth, texture.mHeight, {}};
    for (std::size_t i = 0; i < std::size_t{image.width} * image.height; ++i) {
      const aiTexel& t = texture.pcData[i];
      image.rgba.insert(image.rgba.end(), {t.r, t.g, t.b, t.a});
    }
    return image;
  }

  const aiScene& scene_;
  fs::path folder_;
  SourceMesh& mesh_;
  std::map<std::string, std::uint32_t> numbers_;
};

Result<SourceMesh::Material> material_of(const aiMaterial& from, bool is_linear, Pictures& pictures) {
  SourceMesh::Material material;
  aiColor4D colour(1, 1, 1, 1);
  if (from.Get(AI_MATKEY_BASE_COLOR, colour) != AI_SUCCESS) (void)from.Get(AI_MATKEY_COLOR_DIFFUSE, colour);
  float opacity = 1;
  if (from.Get(AI_MATKEY_OPACITY, opacity) == AI_SUCCESS && colour.a == 1.0f) colour.a = opacity;
  if (is_linear)
    for (float* c : {&colour.r, &colour.g, &colour.b}) *c = srgb_of_linear(*c);
  material.colour = {code_of(colour.r), code_of(colour.g), code_of(colour.b), code_of(colour.a)};
  for (const aiTextureType type : {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE}) {
    aiString name;
    if (from.GetTexture(type, 0, &name) != AI_SUCCESS || name.length == 0) continue;
    const auto image = pictures.take(name.C_Str());
    if (!image) return image.error();
    material.image = *image;
    return material;
  }
  return material;
}

void add_part(const aiMesh& part, bool z_up, SourceMesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (unsigned v = 0; v < part.mNumVertices; ++v) {
    SourceMesh::Vertex vertex;
    vertex.position = turned(part.mVertices[v], z_up);
    if (part.HasNormals()) vertex.normal = turned(part.mNormals[v], z_up);
    if (part.HasTextureCoords(0)) vertex.texture = {part.mTextureCoords[0][v].x, part.mTextureCoords[0][v].y};
    mesh.vertices.push_back(vertex);
  }
  for (unsigned f = 0; f < part.mNumFaces; ++f) {
    const aiFace& face = part.mFaces[f];
    if (face.mNumIndices != 3) continue;
    for (unsigned i = 0; i < 3; ++i) mesh.indices.push_back(first + face.mIndices[i]);
    mesh.materials.push_back(part.mMaterialIndex);
  }
}

Result<SourceMesh> read_model(const fs::path& file) {
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  importer.SetPropertyFloat(AI_CONFIG_PP_GSN_MAX_SMOOTHING_ANGLE, kSmoothDegrees);
  const aiScene* scene = importer.ReadFile(
      file.string(), aiProcess_Triangulate | aiProcess_FindDegenerates | aiProcess_FindInvalidData |
                         aiProcess_SortByPType | aiProcess_PreTransformVertices | aiProcess_GenSmoothNormals |
                         aiProcess_JoinIdenticalVertices | aiProcess_FlipUVs |
                         aiProcess_ValidateDataStructure);
  if (scene == nullptr) return bad_data("expected a model, found: " + std::string(importer.GetErrorString()));
  SourceMesh mesh;
  Pictures pictures(*scene, file.parent_path(), mesh);
  for (unsigned m = 0; m < scene->mNumMaterials; ++m) {
    auto material = material_of(*scene->mMaterials[m], has_linear_colours(file), pictures);
    if (!material) return material.error();
    mesh.palette.push_back(*material);
  }
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) add_part(*scene->mMeshes[m], has_z_up(file), mesh);
  if (mesh.materials.empty()) return bad_data("expected triangles, found none");
  return mesh;
}

Result<SourceMesh> read(const fs::path& file, bool is_image) {
  if (!is_image) return read_model(file);
  auto image = decode_image_file(file);
  if (!image) return image.error();
  SourceMesh mesh;
  mesh.images.push_back(std::move(*image));
  return mesh;
}

}  // namespace
}  // namespace cairn

int main(int argc, char** argv) {
  using namespace cairn;
  const std::string kind = argc == 3 ? argv[1] : "";
  if (kind != "model" && kind != "image") {
    std::fputs("usage: cairn-model model|image FILE\n", stderr);
    return 2;
  }
  set_limits();
  try {
    const auto mesh = read(argv[2], kind == "image");
    if (!mesh) {
      std::fputs(mesh.error().message.c_str(), stderr);
      return 3;
    }
    const auto bytes = encode_mesh(*mesh);
    return std::fwrite(bytes.data(), 1, bytes.size(), stdout) == bytes.size() && std::fflush(stdout) == 0 ? 0
                                                                                                          : 1;
  } catch (const std::exception& error) {
    std::fputs((std::string("expected a model, found: ") + error.what()).c_str(), stderr);
    return 3;
  }
}
