#include "builder/serve/page_files.h"

#include <array>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "format/checksum.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::pair<const char*, const char*>, 12> kTypes{{
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".json", "application/json"},
    {".wasm", "application/wasm"},
    {".txt", "text/plain; charset=utf-8"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".jpg", "image/jpeg"},
    {".gif", "image/gif"},
    {".xml", "application/xml"},
    {".ktx2", "image/ktx2"},
}};

std::string type_of(const fs::path& path) {
  for (const auto& [extension, type] : kTypes)
    if (path.extension() == extension) return type;
  return "application/octet-stream";
}

Result<ServedFile> open_file(const fs::path& path) {
  auto file = File::open_to_read(path);
  if (!file) return file.error();
  const auto bytes = file->size();
  if (!bytes) return bytes.error();
  std::vector<std::byte> content(static_cast<std::size_t>(*bytes));
  if (const Status status = file->read(0, content); !status) return status.error();
  return ServedFile{std::make_shared<const File>(std::move(*file)), *bytes,
                    fmt::format("\"{:016x}\"", checksum(content)), type_of(path), "no-cache"};
}

}  // namespace

Result<PageFiles> PageFiles::open(const fs::path& folder) {
  PageFiles page;
  std::error_code error;
  fs::recursive_directory_iterator at(folder, error), end;
  for (; !error && at != end; at.increment(error)) {
    if (at->is_symlink() || !at->is_regular_file()) continue;
    auto file = open_file(at->path());
    if (!file) return file.error();
    page.files_["/" + at->path().lexically_relative(folder).generic_string()] = std::move(*file);
  }
  if (error) return failed(folder.string() + ": cannot be listed: " + error.message());
  return page;
}

std::optional<HttpAnswer> PageFiles::answer(const HttpRequest& request) const {
  const auto found = files_.find(request.path == "/" ? "/index.html" : request.path);
  if (found == files_.end()) return std::nullopt;
  HttpAnswer answer = answer_with_file(request, found->second);
  // The page may read packs of other servers, and draws with WebGL and WebAssembly.
  if (found->second.content_type.starts_with("text/html"))
    answer.fields.emplace_back("Content-Security-Policy",
                               "default-src 'self' blob: data:; script-src 'self' 'unsafe-eval' blob:; "
                               "style-src 'self' 'unsafe-inline'; connect-src * blob: data:; "
                               "frame-ancestors *; object-src 'none'; base-uri 'self'");
  return answer;
}

}  // namespace cairn
