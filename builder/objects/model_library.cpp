#include "builder/objects/model_library.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <system_error>

#include <fmt/format.h>

#include "builder/objects/billboard.h"
#include "builder/objects/model_geometry.h"
#include "builder/objects/model_process.h"
#include "builder/objects/texture_atlas.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr std::array kMeshExtensions{".gltf", ".glb", ".obj", ".dxf", ".fbx", ".dae",
                                     ".3ds",  ".stl", ".ply", ".off", ".x",   ".ac"};
constexpr std::array kImageExtensions{".png", ".jpg", ".jpeg", ".tga", ".bmp"};
constexpr std::size_t kMostNames = 12;  // in an error
constexpr double kMostMetres = 1e5;
constexpr int kMostPicture = 512;  // texels of a model of an image

template <class Names>
bool is_one_of(const std::string& extension, const Names& names) {
  return std::any_of(names.begin(), names.end(), [&](const char* name) { return extension == name; });
}

std::string small_letters(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

Result<ObjectModel> model_of_image(const std::string& name, const SourceMesh& mesh, double width_m,
                                   double height_m) {
  const SourceMesh::Image& image = mesh.images[0];
  const int side =
      power_of_two_within(static_cast<int>(std::max(image.width, image.height)), 4, kMostPicture);
  ObjectModel model;
  model.name = name;
  model.radius_m = static_cast<float>(width_m / 2);
  model.top_m = static_cast<float>(height_m);
  model.billboard_views = 1;
  model.billboard = texture_of(
      resized({static_cast<int>(image.width), static_cast<int>(image.height), image.rgba}, side, side),
      TextureFormat::bc3);
  return model;
}

}  // namespace

Result<ObjectModel> make_model(const std::string& name, SourceMesh mesh) {
  split_by_material(mesh);
  const TextureAtlas atlas = make_atlas(mesh);
  ObjectModel model;
  model.name = name;
  if (auto status = make_geometry(mesh, atlas.texture, model); !status) return status.error();
  for (const ModelVertex& v : model.vertices) {
    model.radius_m = std::max(model.radius_m, std::hypot(v.position_m[0], v.position_m[1]));
    model.bottom_m = std::min(model.bottom_m, v.position_m[2]);
    model.top_m = std::max(model.top_m, v.position_m[2]);
  }
  if (!(model.size_m() > 1e-4f)) return bad_data("expected a model of 0.1 mm or more, found a smaller one");
  model.texture = texture_of(atlas.picture, TextureFormat::bc1);
  model.billboard_views = kBillboardViews;
  model.billboard = texture_of(draw_billboard(model, atlas.picture), TextureFormat::bc3);
  return model;
}

std::optional<ModelLibrary::Candidate> ModelLibrary::candidate_of(const fs::path& file) {
  const std::string extension = small_letters(file.extension().string());
  Candidate candidate{file.stem().string(), file};
  if (is_one_of(extension, kMeshExtensions)) return candidate;
  if (!is_one_of(extension, kImageExtensions)) return std::nullopt;
  const std::string stem = file.stem().string();
  for (std::size_t dot = stem.find('.', 1); dot < stem.size(); dot = stem.find('.', dot + 1)) {
    double width = 0, height = 0;
    char rest = 0;
    if (std::sscanf(&stem[dot], ".%lfx%lf%c", &width, &height, &rest) != 2) continue;
    if (!(width > 0 && height > 0 && width < kMostMetres && height < kMostMetres)) continue;
    candidate.name = stem.substr(0, dot);
    candidate.width_m = width;
    candidate.height_m = height;
    return candidate;
  }
  return std::nullopt;  // a texture
}

Result<ModelLibrary> ModelLibrary::open(const fs::path& folder) {
  ModelLibrary library;
  library.folder_ = folder;
  std::error_code error;
  for (fs::directory_iterator file(folder, error), end; !error && file != end; file.increment(error)) {
    if (!file->is_regular_file()) continue;
    if (auto candidate = candidate_of(file->path())) library.candidates_.push_back(std::move(*candidate));
  }
  if (error) return usage_error(folder.string() + ": models: expected a folder, found none that can be read");
  auto& all = library.candidates_;
  std::sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) {
    return std::pair(a.name, a.file.string()) < std::pair(b.name, b.file.string());
  });
  for (std::size_t i = 1; i < all.size(); ++i) {
    if (all[i].name == all[i - 1].name)
      return usage_error(fmt::format("{}: models: expected one file for model {}, found {} and {}",
                                     folder.string(), all[i].name, all[i - 1].file.filename().string(),
                                     all[i].file.filename().string()));
  }
  if (all.size() > kMostModels)
    return usage_error(
        fmt::format("{}: models: expected at most {}, found {}", folder.string(), kMostModels, all.size()));
  library.models_.resize(all.size());
  return library;
}

Result<std::size_t> ModelLibrary::find(std::string_view name) const {
  const auto found = std::lower_bound(candidates_.begin(), candidates_.end(), name,
                                      [](const Candidate& c, std::string_view n) { return c.name < n; });
  if (found != candidates_.end() && found->name == name)
    return static_cast<std::size_t>(found - candidates_.begin());
  std::string names;
  for (std::size_t i = 0; i < std::min(candidates_.size(), kMostNames); ++i)
    names += (i == 0 ? "" : ", ") + candidates_[i].name;
  if (candidates_.size() > kMostNames) names += ", …";
  return bad_data(fmt::format("model: expected one of {} ({}), found '{}'", folder_.string(),
                              names.empty() ? "which has none" : names, name.substr(0, 40)));
}

Result<const ModelLibrary::Model*> ModelLibrary::load(std::size_t place) {
  std::optional<Model>& model = models_[place];
  if (model) return &*model;
  const Candidate& from = candidates_[place];
  if (from.name.size() > UINT8_MAX)
    return bad_data(from.file.string() + ": expected a name of at most 255 bytes, found more");
  const bool is_image = from.width_m > 0;
  auto mesh = is_image ? read_image_file(from.file) : read_model_file(from.file);
  if (!mesh) return mesh.error();
  const auto made = is_image ? model_of_image(from.name, *mesh, from.width_m, from.height_m)
                             : make_model(from.name, std::move(*mesh));
  if (!made) return Error{made.error().code, from.file.string() + ": " + made.error().message};
  Model stored;
  stored.name = from.name;
  stored.block = encode_model_block(*made);
  const auto decoded = decode_model_block(stored.block);
  if (!decoded) return Error{decoded.error().code, from.file.string() + ": " + decoded.error().message};
  stored.size_m = decoded->size_m();
  stored.triangles = decoded->levels.empty() ? 0 : decoded->levels[0].count / 3;
  stored.vertices = decoded->vertices.size();
  stored.levels = decoded->levels.size();
  model = std::move(stored);
  return &*model;
}

std::vector<std::pair<std::size_t, const ModelLibrary::Model*>> ModelLibrary::loaded() const {
  std::vector<std::pair<std::size_t, const Model*>> all;
  for (std::size_t i = 0; i < models_.size(); ++i)
    if (models_[i]) all.emplace_back(i, &*models_[i]);
  return all;
}

std::vector<fs::path> files_of_models(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::recursive_directory_iterator file(folder, error), end; !error && file != end;
       file.increment(error)) {
    if (file->is_regular_file()) files.push_back(file->path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace cairn
