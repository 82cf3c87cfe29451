#include "builder/shard/part_file.h"

#include <algorithm>
#include <array>
#include <span>

#include <nlohmann/json.hpp>

#include "builder/bake/bake_session.h"
#include "builder/shard/shard_plan.h"
#include "format/checksum.h"

namespace cairn {
namespace {

using SortedJson = nlohmann::json;

// The first record of a part: its description as JSON.
std::vector<std::byte> encode(const PartDescription& d) {
  const std::string text = SortedJson{{"cairn_part", 1},  {"cairn", d.version}, {"key", hex_of(d.key)},
                                      {"shard", d.shard}, {"shards", d.shards}, {"units", d.units}}
                               .dump();
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

std::optional<PartDescription> decode(std::span<const std::byte> bytes) {
  const auto* text = reinterpret_cast<const char*>(bytes.data());
  const SortedJson json = SortedJson::parse(text, text + bytes.size(), nullptr, false);
  if (!json.is_object() || json.value("cairn_part", SortedJson()) != 1) return std::nullopt;
  try {
    return PartDescription{json.at("cairn").get<std::string>(),
                           std::stoull(json.at("key").get<std::string>(), nullptr, 16),
                           json.at("shard").get<std::size_t>(), json.at("shards").get<std::size_t>(),
                           json.at("units").get<std::uint64_t>()};
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

std::uint64_t fingerprint_of(const PartDescription& description) {
  return checksum(encode(description));
}

}  // namespace

Result<PartWriter> PartWriter::begin(const SessionOptions& session, const PartDescription& description) {
  const std::uint64_t own = fingerprint_of(description);
  const auto found = Journal::fingerprint_of(session.target);
  if (session.resume && found && *found != own && !session.force)
    return usage_error(Journal::path_for(session.target).string() + std::string(kOtherWork));
  std::vector<RecordPlace> done;
  if (session.resume)
    done = Journal::find_records(session.target, own, [](const UnitRecord&) { return true; });
  if (!done.empty()) {
    auto journal = Journal::reopen(session.target, done);
    if (!journal) return journal.error();
    PartWriter part(session.target, std::move(*journal));
    part.bytes_ = done.back().end;
    done.erase(done.begin());
    part.done_ = std::move(done);
    return part;
  }
  auto journal = Journal::create(session.target);
  if (!journal) return journal.error();
  if (auto status = journal->identify(own); !status) return status.error();
  PartWriter part(session.target, std::move(*journal));
  UnitRecord first;
  first.root = encode(description);
  if (auto status = part.journal_.append(first); !status) return status.error();
  return part;
}

Result<PartRecord> PartWriter::read_done(std::size_t number) const {
  const auto record = journal_.read(done_[number]);
  if (!record) return record.error();
  auto part = decode_part_record(record->root);
  if (!part) return bad_data(Journal::path_for(target_).string() + ": " + part.error().message);
  return part;
}

Status PartWriter::append(const PartRecord& record) {
  UnitRecord unit;
  unit.root = encode_part_record(record);
  bytes_ += unit.root.size();
  return journal_.append(unit);
}

Status PartWriter::finish() {
  return journal_.keep_as(target_);
}

Result<PartReader> PartReader::open(const std::filesystem::path& path) {
  auto journal = JournalReader::open(path);
  if (!journal) return journal.error();
  auto first = journal->next();
  if (!first) return first.error();
  const auto description = *first ? decode((*first)->root) : std::nullopt;
  if (!description) return bad_data(path.string() + ": expected a part of a plan, found another file");
  PartReader part(path, std::move(*journal));
  part.description_ = *description;
  return part;
}

Result<PartReader> PartReader::open_at(const std::filesystem::path& path, std::uint64_t position) {
  auto part = open(path);
  if (part) part->journal_.go_to(position);
  return part;
}

Result<PartRecord> PartReader::next() {
  auto record = journal_.next();
  if (!record) return record.error();
  if (!*record)
    return bad_data(path_.string() + ": expected " + std::to_string(description_.units) +
                    " units, found that it ends before");
  auto part = decode_part_record((*record)->root);
  if (!part) return bad_data(path_.string() + ": " + part.error().message);
  return part;
}

Status PartReader::check_end() {
  const auto record = journal_.next();
  if (!record) return record.error();
  if (!*record) return {};
  return bad_data(path_.string() + ": expected " + std::to_string(description_.units) + " units, found more");
}

}  // namespace cairn
