#include "cairn/pack_reader.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <new>

#include "format/bytes.h"
#include "format/checksum.h"
#include "format/file.h"
#include "format/height_block.h"

namespace cairn {
namespace {

constexpr std::size_t kLayers = 3;

/// The key of an entry in the index, without the rest of it.
struct EntryKey {
  Layer layer;
  TileId id;
};

EntryKey key_at(std::span<const std::byte> entry) {
  ByteReader in(entry);
  EntryKey key{};
  key.layer = static_cast<Layer>(in.read<std::uint8_t>());
  key.id.level = in.read<std::int8_t>();
  in.read<std::uint16_t>();
  key.id.x = in.read<std::int32_t>();
  key.id.y = in.read<std::int32_t>();
  return key;
}

bool key_before(const EntryKey& a, const EntryKey& b) {
  return a.layer != b.layer ? a.layer < b.layer : a.id < b.id;
}

Error in_file(const std::filesystem::path& path, const std::string& place, const Error& error) {
  return {error.code, path.string() + ": " + (place.empty() ? "" : place + ": ") + error.message};
}

Result<PackHeader> read_header(const File& file) {
  const Result<std::uint64_t> size = file.size();
  if (!size) return size.error();
  std::array<std::byte, kPackHeaderBytes> bytes{};
  const std::size_t there = *size < bytes.size() ? static_cast<std::size_t>(*size) : bytes.size();
  if (const Status status = file.read(0, std::span(bytes).first(there)); !status) return status.error();
  Result<PackHeader> header = decode_header(std::span(bytes).first(there));
  if (!header) return in_file(file.path(), "", header.error());
  if (header->file_bytes() != *size) {
    return bad_data(file.path().string() + ": file size: expected " + std::to_string(header->file_bytes()) +
                    " bytes as the header says, found " + std::to_string(*size));
  }
  return header;
}

Status check_checksum(const File& file, const char* what, std::span<const std::byte> bytes,
                      std::uint64_t expected) {
  if (checksum(bytes) == expected) return {};
  return bad_data(file.path().string() + ": " + what + ": checksum: expected the header's, found another");
}

/// REQUIRES: the file has these bytes.
Result<std::vector<std::byte>> read_bytes(const File& file, std::uint64_t offset, std::uint64_t count) {
  std::vector<std::byte> bytes;
  try {
    bytes.resize(count);
  } catch (const std::bad_alloc&) {
    return failed(file.path().string() + ": index: expected memory for " + std::to_string(count) +
                  " bytes, found too little");
  }
  if (const Status status = file.read(offset, bytes); !status) return status.error();
  return bytes;
}

}  // namespace

struct PackReader::State {
  File file;
  PackHeader header;
  std::vector<std::byte> tail;                            // index, then metadata
  std::array<std::optional<LevelRange>, kLayers> levels;  // by layer

  std::span<const std::byte> index() const {
    return std::span(tail).first(header.index_count * kIndexEntryBytes);
  }
  std::span<const std::byte> metadata() const { return std::span(tail).subspan(index().size()); }
  std::span<const std::byte> entry_bytes(std::size_t i) const {
    return index().subspan(i * kIndexEntryBytes, kIndexEntryBytes);
  }
  bool in_block_area(const IndexEntry& entry) const {
    return entry.offset >= kPackHeaderBytes && entry.offset <= header.index_offset &&
           entry.bytes <= header.index_offset - entry.offset;
  }
  Status validate_index();
  void note_level(const IndexEntry& entry);
};

void PackReader::State::note_level(const IndexEntry& entry) {
  auto& range = levels[static_cast<std::size_t>(entry.layer)];
  if (!range) range = LevelRange{entry.id.level, entry.id.level};
  range->finest = entry.id.level;  // the index ascends by level
}

Status PackReader::State::validate_index() {
  std::optional<IndexEntry> previous;
  for (std::size_t i = 0; i < header.index_count; ++i) {
    const std::string place = "index entry " + std::to_string(i);
    const Result<IndexEntry> entry = decode_entry(entry_bytes(i));
    if (!entry) return in_file(file.path(), place, entry.error());
    if (previous && !entry_before(*previous, *entry)) {
      return in_file(
          file.path(), place,
          bad_data("expected a tile after " + to_string(previous->id) + ", found " + to_string(entry->id)));
    }
    if (entry->bytes != 0 && !in_block_area(*entry)) {
      return in_file(
          file.path(), place,
          bad_data("expected a block before byte " + std::to_string(header.index_offset) + ", found " +
                   std::to_string(entry->bytes) + " bytes at " + std::to_string(entry->offset)));
    }
    note_level(*entry);
    previous = *entry;
  }
  return {};
}

PackReader::PackReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
PackReader::PackReader(PackReader&&) noexcept = default;
PackReader& PackReader::operator=(PackReader&&) noexcept = default;
PackReader::~PackReader() = default;

Result<PackReader> PackReader::open(const std::filesystem::path& path) {
  Result<File> file = File::open_to_read(path);
  if (!file) return file.error();
  const Result<PackHeader> header = read_header(*file);
  if (!header) return header.error();
  Result<std::vector<std::byte>> tail =
      read_bytes(*file, header->index_offset, header->file_bytes() - header->index_offset);
  if (!tail) return tail.error();
  std::unique_ptr<State> state(new State{std::move(*file), *header, std::move(*tail), {}});
  Status status = check_checksum(state->file, "index", state->index(), header->index_checksum);
  if (status) status = check_checksum(state->file, "metadata", state->metadata(), header->metadata_checksum);
  if (status) status = state->validate_index();
  if (!status) return status.error();
  return PackReader(std::move(state));
}

const std::filesystem::path& PackReader::path() const {
  return state_->file.path();
}

const PackHeader& PackReader::header() const {
  return state_->header;
}

std::string_view PackReader::metadata_json() const {
  const auto bytes = state_->metadata();
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::size_t PackReader::entry_count() const {
  return static_cast<std::size_t>(state_->header.index_count);
}

IndexEntry PackReader::entry(std::size_t index) const {
  assert(index < entry_count());
  const Result<IndexEntry> entry = decode_entry(state_->entry_bytes(index));
  return *entry;
}

std::optional<std::size_t> PackReader::find_index(Layer layer, const TileId& id) const {
  const EntryKey wanted{layer, id};
  std::size_t first = 0;
  std::size_t last = entry_count();
  while (first < last) {
    const std::size_t middle = first + (last - first) / 2;
    if (key_before(key_at(state_->entry_bytes(middle)), wanted)) {
      first = middle + 1;
    } else {
      last = middle;
    }
  }
  if (first == entry_count() || key_before(wanted, key_at(state_->entry_bytes(first)))) return std::nullopt;
  return first;
}

std::optional<IndexEntry> PackReader::find(Layer layer, const TileId& id) const {
  const std::optional<std::size_t> index = find_index(layer, id);
  if (!index) return std::nullopt;
  return entry(*index);
}

std::optional<IndexEntry> PackReader::find_nearest(Layer layer, const TileId& id) const {
  const std::optional<LevelRange> range = levels(layer);
  if (!range) return std::nullopt;
  for (int level = std::min(id.level, range->finest); level >= range->coarsest; --level) {
    if (auto found = find(layer, ancestor_of(id, level))) return found;
  }
  return std::nullopt;
}

std::optional<PackReader::LevelRange> PackReader::levels(Layer layer) const {
  return state_->levels[static_cast<std::size_t>(layer)];
}

Result<std::vector<std::byte>> PackReader::read_block(const IndexEntry& entry) const {
  std::vector<std::byte> block;
  if (entry.bytes == 0) return block;
  const std::string place = std::string(to_string(entry.layer)) + " tile " + to_string(entry.id);
  if (!state_->in_block_area(entry)) {
    return in_file(path(), place, bad_data("expected a block among the pack's, found one outside"));
  }
  block.resize(entry.bytes);
  if (const Status status = state_->file.read(entry.offset, block); !status) return status.error();
  if (checksum(block) != entry.checksum) {
    return in_file(path(), place, bad_data("block: checksum: expected the index's, found another"));
  }
  return block;
}

Result<HeightTile> PackReader::read_height_tile(const IndexEntry& entry) const {
  assert(entry.layer == Layer::heights);
  const int size = header().tile_size;
  if ((entry.flags & kConstant) != 0) {
    const auto side = static_cast<std::size_t>(size);
    return HeightTile{size, std::vector<std::int32_t>(side * side, entry.min_quanta), {}};
  }
  const Result<std::vector<std::byte>> block = read_block(entry);
  if (!block) return block.error();
  Result<HeightTile> tile = decode_height_block(*block, size);
  if (!tile) return in_file(path(), "heights tile " + to_string(entry.id), tile.error());
  return tile;
}

}  // namespace cairn
