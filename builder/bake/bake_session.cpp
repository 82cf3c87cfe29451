#include "builder/bake/bake_session.h"

#include <algorithm>
#include <system_error>

#include "format/checksum.h"
#include "format/file.h"

namespace cairn {
namespace {

bool block_is_whole(const File& part, std::uint64_t part_bytes, const IndexEntry& entry,
                    std::vector<std::byte>& buffer) {
  if (entry.bytes == 0) return true;  // a constant tile has no block
  if (entry.offset > part_bytes || entry.bytes > part_bytes - entry.offset) return false;
  buffer.resize(entry.bytes);
  return part.read(entry.offset, buffer).ok() && checksum(buffer) == entry.checksum;
}

// The units, from the first on, whose blocks are all in the unfinished pack.
std::vector<RecordPlace> whole_units(const std::filesystem::path& target, std::uint64_t fingerprint) {
  const auto part = File::open_to_read(std::filesystem::path(target).concat(".part"));
  if (!part) return {};
  const auto size = part->size();
  if (!size) return {};
  std::vector<std::byte> buffer;
  return Journal::find_records(target, fingerprint, [&](const UnitRecord& record) {
    return std::all_of(record.entries.begin(), record.entries.end(),
                       [&](const IndexEntry& e) { return block_is_whole(*part, *size, e, buffer); });
  });
}

Result<BakeSession> begin(const SessionOptions& options, BakeIdentity&& identity, const PackHeader& header) {
  auto writer = PackWriter::create(options.target, header);
  if (!writer) return writer.error();
  auto journal = Journal::create(options.target);
  if (!journal) {
    writer->abandon();
    return journal.error();
  }
  return BakeSession{options, std::move(identity), std::move(*writer), std::move(*journal), {}, std::nullopt,
                     false};
}

Result<BakeSession> resume(const SessionOptions& options, BakeIdentity&& identity, const PackHeader& header,
                           std::vector<RecordPlace> done) {
  auto journal = Journal::reopen(options.target, done);
  if (!journal) return journal.error();
  auto writer = PackWriter::reopen(options.target, header, [&](const PackWriter::TakeEntry& take) -> Status {
    for (const RecordPlace& place : done) {
      const auto record = journal->read(place);
      if (!record) return record.error();
      for (const IndexEntry& entry : record->entries) {
        if (Status status = take(entry); !status) return status;
      }
    }
    return {};
  });
  if (!writer) return writer.error();
  return BakeSession{
      options, std::move(identity), std::move(*writer), std::move(*journal), std::move(done), std::nullopt,
      true};
}

}  // namespace

Result<BakeSession> begin_session(const SessionOptions& options, BakeIdentity identity,
                                  const PackHeader& header) {
  std::error_code ignored;
  if (!options.resume || !std::filesystem::exists(Journal::path_for(options.target), ignored))
    return begin(options, std::move(identity), header);
  const auto hashes = hash_files(identity.inputs);
  if (!hashes) return hashes.error();
  const std::uint64_t own = fingerprint(identity.options, *hashes);
  const auto found = Journal::fingerprint_of(options.target);
  if (found && *found != own && !options.force)
    return usage_error(Journal::path_for(options.target).string() + std::string(kOtherWork));
  std::vector<RecordPlace> done = whole_units(options.target, own);
  auto session = done.empty() ? begin(options, std::move(identity), header)
                              : resume(options, std::move(identity), header, std::move(done));
  if (session) session->input_hashes = *hashes;
  return session;
}

InputHashing::InputHashing(BakeSession& session) : session_(session) {
  const OrderedTurn turn(order_);
  tasks_.run([this] {
    const OrderedTurn taken(order_);
    hash();
  });
}

InputHashing::~InputHashing() {
  tasks_.cancel();
  tasks_.wait();
  const OrderedTurn turn(order_);
}

void InputHashing::hash() {
  hashes_ = session_.input_hashes ? *session_.input_hashes : hash_files(session_.identity.inputs);
  if (!*hashes_) return;
  const std::uint64_t print = fingerprint(session_.identity.options, **hashes_);
  if (auto status = session_.journal.identify(print); !status) hashes_ = status.error();
}

Result<std::vector<std::uint64_t>> InputHashing::hashes() {
  tasks_.wait();
  const OrderedTurn turn(order_);
  return *hashes_;
}

// A damaged input would end another try at the same place, and a mended one is another input.
Error end_failed_bake(BakeSession& session, InputHashing& hashing, Error error) {
  const bool may_succeed = session.options.resume || error.code == ErrorCode::failed;
  if (may_succeed && !session.journal.is_empty() && hashing.hashes().ok()) return error;
  session.writer.abandon();
  remove_journal(session.options.target);
  return error;
}

void remove_journal(const std::filesystem::path& target) {
  std::error_code ignored;
  std::filesystem::remove(Journal::path_for(target), ignored);
}

}  // namespace cairn
