#include "builder/serve/pack_service.h"

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

#include "builder/export/pack_accuracy.h"
#include "builder/serve/height_requests.h"
#include "builder/serve/tile_requests.h"
#include "builder/serve/url_text.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

Json pack_json(const std::string& name, const OpenedPack& pack, bool is_streamed) {
  const PackHeader& header = pack.reader.header();
  Json json = {{"name", name},
               {"url", "packs/" + escape_path(name)},
               {"id", to_string(header.id)},
               {"bytes", header.file_bytes()},
               {"vertical_datum", header.datum_name()}};
  if (is_streamed) json["stream"] = "stream/" + escape_path(name);
  const PackAccuracy accuracy = accuracy_of(pack.reader);
  if (accuracy.bounds)
    json["bounds"] = {accuracy.bounds->west, accuracy.bounds->south, accuracy.bounds->east,
                      accuracy.bounds->north};
  return json;
}

/// Returns the parts of a path after its first two slashes: "/packs/a/b" has "a" and "b".
std::pair<std::string, std::string> name_and_rest(const std::string& path) {
  const std::size_t name = path.find('/', 1) + 1;
  const std::size_t end = path.find('/', name);
  if (end == std::string::npos) return {path.substr(name), ""};
  return {path.substr(name, end - name), path.substr(end + 1)};
}

}  // namespace

Result<PackService> PackService::open(const std::vector<std::filesystem::path>& packs,
                                      const std::optional<std::filesystem::path>& page,
                                      std::unique_ptr<StreamService> streams) {
  PackService service;
  service.streams_ = std::move(streams);
  for (const std::filesystem::path& path : packs) {
    auto pack = ServedPack::open(path);
    if (!pack) return pack.error();
    if (service.find(pack->name()) != nullptr)
      return usage_error(path.string() + ": expected packs of different names, found two of this one");
    service.packs_.push_back(std::move(*pack));
  }
  if (page) {
    auto files = PageFiles::open(*page);
    if (!files) return files.error();
    service.page_ = std::move(*files);
  }
  return service;
}

const ServedPack* PackService::find(const std::string& name) const {
  const auto found =
      std::find_if(packs_.begin(), packs_.end(), [&](const ServedPack& p) { return p.name() == name; });
  return found == packs_.end() ? nullptr : &*found;
}

HttpAnswer PackService::list() const {
  Json json = Json::array();
  for (const ServedPack& served : packs_) {
    const auto pack = served.now();
    json.push_back(pack ? pack_json(served.name(), **pack, streams_ != nullptr)
                        : Json{{"name", served.name()}, {"error", pack.error().message}});
  }
  return json_answer(json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

HttpAnswer PackService::answer_with_pack(const HttpRequest& request) const {
  const auto [name, rest] = name_and_rest(request.path);
  const ServedPack* served = find(name);
  if (served == nullptr) return error_answer(404, "pack: expected one that is served, found " + name);
  const auto pack = served->now();
  if (!pack) return error_answer(503, pack.error().message);
  if (request.path.starts_with("/terrarium/")) return answer_terrarium(request, name, **pack, rest);
  if (request.path.starts_with("/stream/") && rest.empty())
    return streams_ ? streams_->answer(request, served->path())
                    : error_answer(404, "stream: this server draws no pictures");
  if (request.path.starts_with("/quantized-mesh/")) return answer_quantized_mesh(request, name, **pack, rest);
  return rest.empty() ? answer_with_file(request, (*pack)->served)
                      : error_answer(404, "path: expected /packs/NAME, found " + request.path);
}

HttpAnswer PackService::answer(const HttpRequest& request) const {
  if (request.path == "/packs.json") return list();
  if (request.path == "/heights") return answer_heights(request, packs_);
  if (request.path.starts_with("/packs/") || request.path.starts_with("/terrarium/") ||
      request.path.starts_with("/quantized-mesh/") || request.path.starts_with("/stream/"))
    return answer_with_pack(request);
  if (auto file = page_.answer(request)) return *file;
  if (request.path == "/")
    return {200,
            {{"Content-Type", "text/plain; charset=utf-8"}, {"Cache-Control", "no-cache"}},
            "cairn serve: the page is not installed here. /packs.json lists the packs.\n",
            {}};
  return error_answer(404,
                      "path: expected /, /packs.json, /packs/NAME, /heights, /terrarium/NAME, "
                      "/quantized-mesh/NAME or /stream/NAME, found " +
                          request.path);
}

}  // namespace cairn
