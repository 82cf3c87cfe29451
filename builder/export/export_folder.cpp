#include "builder/export/export_folder.h"

#include <system_error>

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr const char* kJournal = "export.journal";

std::span<const std::byte> file_bytes(const std::string& text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

/// The whole lines of a journal; what follows the last line break was cut off by a kill.
Result<std::vector<std::string>> lines_of(const File& file) {
  const auto size = file.size();
  if (!size) return size.error();
  std::string text(*size, '\0');
  if (auto status = file.read(0, std::as_writable_bytes(std::span(text.data(), text.size()))); !status)
    return status.error();
  std::vector<std::string> lines;
  for (std::size_t from = 0;;) {
    const std::size_t end = text.find('\n', from);
    if (end == std::string::npos) return lines;
    lines.push_back(text.substr(from, end - from));
    from = end + 1;
  }
}

}  // namespace

Result<ExportFolder> ExportFolder::begin(const fs::path& target, const std::string& identity, bool resume) {
  std::error_code error;
  fs::path named = target;
  if (!named.has_filename()) named = named.parent_path();  // NAME/
  const fs::path folder = named.has_parent_path() ? named.parent_path() : fs::path(".");
  if (fs::exists(fs::symlink_status(named, error)))
    return usage_error(named.string() + ": expected no such file or folder, found one");
  if (!fs::is_directory(folder, error))
    return failed(named.string() + ": expected a folder " + folder.string() + ", found none");
  const fs::path part = named.string() + ".part";
  const bool there = fs::exists(fs::symlink_status(part, error));
  if (there && !fs::is_regular_file(part / kJournal, error))
    return usage_error(part.string() + ": expected no such file, which is written first, found one");
  if (there && !resume)
    return usage_error(part.string() + ": expected no such folder, found the work of an interrupted export");
  if (!there && !fs::create_directory(part, error))
    return failed(part.string() + ": create: " + error.message());
  auto journal = File::open_to_write(part / kJournal);
  if (!journal) return journal.error();
  ExportFolder out(named, part, std::move(*journal));
  auto lines = lines_of(out.journal_);
  if (!lines) return lines.error();
  if (lines->empty()) {
    if (auto status = out.journal_.truncate(0); !status) return status.error();
    if (auto status = out.append(identity); !status) return status.error();
    return out;
  }
  if (lines->front() != identity)
    return usage_error(part.string() +
                       ": expected an export of this pack with these options, found another's");
  for (const std::string& line : *lines) out.end_ += line.size() + 1;
  out.done_.assign(lines->begin() + 1, lines->end());
  if (auto status = out.journal_.truncate(out.end_); !status) return status.error();
  return out;
}

Status ExportFolder::write(const fs::path& name, std::span<const std::byte> bytes) const {
  const fs::path path = part_ / name;
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  if (error) return failed(path.parent_path().string() + ": create: " + error.message());
  auto file = File::open_to_write(path);
  if (!file) return file.error();
  if (auto status = file->truncate(0); !status) return status;
  return file->write(0, bytes);
}

Status ExportFolder::write(const fs::path& name, const std::string& text) const {
  return write(name, file_bytes(text));
}

Status ExportFolder::append(const std::string& line) {
  if (auto status = journal_.write(end_, file_bytes(line + "\n")); !status) return status;
  end_ += line.size() + 1;
  return {};
}

Status ExportFolder::finish() {
  std::error_code error;
  if (!fs::remove(part_ / kJournal, error) || error)
    return failed((part_ / kJournal).string() + ": remove: " + error.message());
  return rename_durably(part_, target_);
}

Status ExportFolder::finish_as_file(const fs::path& name) {
  if (auto status = rename_durably(part_ / name, target_); !status) return status;
  std::error_code error;
  fs::remove_all(part_, error);
  return error ? Status(failed(part_.string() + ": remove: " + error.message())) : Status();
}

void ExportFolder::discard() {
  std::error_code ignored;
  fs::remove_all(part_, ignored);
}

}  // namespace cairn
