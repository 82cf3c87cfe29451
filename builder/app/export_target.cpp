#include "builder/app/export_target.h"

#include <set>
#include <string>
#include <system_error>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "builder/app/pack_metadata.h"
#include "builder/bake/fingerprint.h"
#include "builder/bake/output_check.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

void add_hashes(const json& sources, std::set<std::string>& hashes) {
  if (!sources.is_array()) return;
  for (const json& source : sources)
    if (source.is_object() && source.contains("xxh3") && source.at("xxh3").is_string())
      hashes.insert(source.at("xxh3").get<std::string>());
}

std::set<std::string> hashes_of_sources(const PackReader& pack) {
  std::set<std::string> hashes;
  const auto metadata = parse_metadata(pack);
  if (!metadata) return hashes;
  const auto at = [&](const char* place) {
    const json::json_pointer pointer(place);
    return metadata->contains(pointer) ? metadata->at(pointer) : json();
  };
  add_hashes(at("/sources"), hashes);
  add_hashes(at("/imagery/sources"), hashes);
  return hashes;
}

}  // namespace

Status check_export_target(const fs::path& output, const PackReader& pack) {
  const fs::path part = output.string() + ".part";
  for (const fs::path& written : {output, part})
    if (is_same_file(written, pack.path()))
      return usage_error(output.string() + ": expected an output that is not the pack, found the pack");
  if (auto status = check_can_be_file(output); !status) return status;
  std::error_code ignored;
  if (fs::exists(fs::symlink_status(part, ignored)))
    return usage_error(part.string() + ": expected no such file, which is written first, found one");
  if (!fs::is_regular_file(output, ignored) || fs::file_size(output, ignored) == 0) return {};
  const std::set<std::string> sources = hashes_of_sources(pack);
  if (sources.empty()) return {};
  const auto hash = hash_file(output);
  if (!hash) return hash.error();
  if (!sources.contains(fmt::format("{:016x}", *hash))) return {};
  return usage_error(output.string() + ": expected an output that is no source of the pack, found one");
}

}  // namespace cairn
