#include "builder/shard/planned_bake.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <string>
#include <string_view>
#include <system_error>

#include <tbb/parallel_for.h>

#include "builder/bake/fingerprint.h"
#include "builder/pack/options_json.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

// What raster readers look for beside a file: FILE + ending, or the file's own ending replaced.
constexpr std::array<std::string_view, 3> kAppended = {".aux.xml", ".msk", ".ovr"};
constexpr std::array<std::string_view, 15> kReplacing = {".tfw", ".tifw", ".tiffw", ".pgw", ".pngw",
                                                         ".jgw", ".jpgw", ".jpegw", ".jpw", ".j2w",
                                                         ".wld", ".prj",  ".hdr",   ".blw", ".stx"};

std::vector<fs::path> side_cars_of(const fs::path& file) {
  std::vector<fs::path> found;
  std::error_code ignored;
  const auto take = [&](const fs::path& path) {
    if (path != file && fs::is_regular_file(path, ignored)) found.push_back(path);
  };
  for (const std::string_view ending : kAppended) take(fs::path(file).concat(ending));
  for (const std::string_view ending : kReplacing) take(fs::path(file).replace_extension(ending));
  return found;
}

Result<PlannedFile> look_at_one(const fs::path& path) {
  std::error_code error;
  PlannedFile file{path, fs::file_size(path, error), 0, {}};
  if (error) return failed(path.string() + ": expected a file that can be read, found none");
  const auto hash = hash_file(path);
  if (!hash) return hash.error();
  file.hash = *hash;
  return file;
}

Status check_file(const PlannedFile& planned) {
  const auto now = look_at_one(planned.path);
  if (!now) return now.error();
  if (now->bytes != planned.bytes || now->hash != planned.hash)
    return bad_data(planned.path.string() + ": expected the file as it was planned, of " +
                    std::to_string(planned.bytes) + " bytes and the hash " + hex_of(planned.hash) +
                    ", found one of " + std::to_string(now->bytes) + " bytes and the hash " +
                    hex_of(now->hash));
  for (const PlannedFile& beside : planned.beside) {
    if (auto status = check_file(beside); !status) return status;
  }
  return {};
}

Status check_all(const ShardPlan& plan, const std::vector<std::size_t>& numbers) {
  std::vector<Status> found(numbers.size());
  tbb::parallel_for(std::size_t{0}, found.size(),
                    [&](std::size_t i) { found[i] = check_file(plan.files[numbers[i]]); });
  const auto first = std::find_if(found.begin(), found.end(), [](const Status& s) { return !s.ok(); });
  return first == found.end() ? Status() : *first;
}

}  // namespace

Result<BuildOptions> options_of(const ShardPlan& plan) {
  auto options = from_json(plan.options);
  if (!options) return options.error();
  const std::size_t dems = plan.dems.size(), images = plan.images.size();
  for (std::size_t f = 0; f < dems; ++f) options->mosaic.inputs.push_back(plan.dems[f].path);
  for (std::size_t f = 0; f < images; ++f) options->imagery.inputs.push_back(plan.images[f].path);
  if (plan.with_geoid) options->mosaic.geoid = plan.files[dems + images].path;
  for (std::size_t p = 0; p < plan.places; ++p)
    options->objects.places.push_back(plan.files[plan.first_of_objects() + p].path);
  options->objects.models = plan.models;
  options->heights.allow_error = plan.allow_error;
  options->session.memory_bytes = plan.memory_bytes;
  return options;
}

KnownSources sources_of(const ShardPlan& plan, std::optional<std::size_t> shard) {
  KnownSources sources{plan.dems, plan.images, std::vector<bool>(plan.dems.size(), false),
                       std::vector<bool>(plan.images.size(), false)};
  sources.geoid_available = false;
  if (!shard) return sources;
  for (const std::size_t file : plan.shards[*shard].files) {
    if (file < plan.dems.size()) {
      sources.dems_available[file] = true;
    } else if (file - plan.dems.size() < plan.images.size()) {
      sources.images_available[file - plan.dems.size()] = true;
    } else {
      sources.geoid_available = true;
    }
  }
  return sources;
}

Result<PlannedFile> look_at(const fs::path& path) {
  auto file = look_at_one(path);
  if (!file) return file;
  for (const fs::path& beside : side_cars_of(path)) {
    auto other = look_at_one(beside);
    if (!other) return other;
    file->beside.push_back(std::move(*other));
  }
  return file;
}

Status check_files(const ShardPlan& plan, const Shard& shard) {
  return check_all(plan, shard.files);
}

Status check_object_files(const ShardPlan& plan, const BuildOptions& options) {
  if (plan.places == 0) return {};
  std::vector<std::size_t> numbers(plan.files.size() - plan.first_of_objects());
  std::iota(numbers.begin(), numbers.end(), plan.first_of_objects());
  if (auto status = check_all(plan, numbers); !status) return status;
  const std::size_t before = plan.first_of_objects() + plan.places, found = files_of(options).size();
  if (found == plan.files.size()) return {};
  return bad_data(plan.models.string() + ": models: expected the " +
                  std::to_string(plan.files.size() - before) + " files that were planned, found " +
                  std::to_string(found - before));
}

}  // namespace cairn
