#include "cairn/pack_reader.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <mutex>

#include "format/checked_read.h"
#include "format/file.h"
#include "format/height_block.h"
#include "format/pack_index.h"
#include "format/tile_number.h"

namespace cairn {
namespace {

constexpr std::uint64_t kMostReadAhead = std::uint64_t{4} << 20;

class FileSource : public ByteSource {
 public:
  explicit FileSource(File file) : file_(std::move(file)) {}

  const std::filesystem::path& name() const override { return file_.path(); }
  Result<std::uint64_t> size() const override { return file_.size(); }
  using ByteSource::read;
  Status read(std::uint64_t offset, std::span<std::byte> out) const override {
    return file_.read(offset, out);
  }

 private:
  File file_;
};

std::string name_of(const IndexEntry& entry) {
  return std::string(to_string(entry.layer)) + " tile " + to_string(entry.id);
}

IndexEntry unreadable(Layer layer, const TileId& id) {
  IndexEntry entry;
  entry.layer = layer;
  entry.id = id;
  entry.flags = kUnreadable;
  return entry;
}

}  // namespace

struct PackReader::State {
  std::unique_ptr<const ByteSource> source;
  PackHeader header;
  std::unique_ptr<PackIndex> index;
  std::array<std::optional<LevelRange>, kLayers> levels;  // by layer

  mutable std::mutex metadata_mutex;
  mutable std::optional<std::string> metadata;  // guarded by metadata_mutex; kept once it is there

  Result<std::array<std::byte, kPackStartBytes>> read_start() const;
  Status open();
  Status read_metadata() const;
  bool in_block_area(const IndexEntry& entry) const;
  Result<std::optional<PackIndex::Found>> look_up(Layer layer, const TileId& id) const;
  Status check_readable(const IndexEntry& entry) const;
  std::vector<ByteRange> siblings_of(const IndexEntry& entry) const;
};

// The header is read alone where the file is shorter than header and root, so that what is no pack is told
// so.
Result<std::array<std::byte, kPackStartBytes>> PackReader::State::read_start() const {
  const Result<std::uint64_t> size = source->size();
  if (!size) return size.error();
  std::array<std::byte, kPackStartBytes> bytes{};
  const auto there =
      std::span(bytes).first(static_cast<std::size_t>(std::min<std::uint64_t>(*size, bytes.size())));
  if (const Status status = source->read(0, there); !status) return status.error();
  const Result<PackHeader> decoded = decode_header(there.first(std::min(there.size(), kPackHeaderBytes)));
  if (!decoded) return in_file(*source, "", decoded.error());
  if (decoded->file_bytes() != *size) {
    return in_file(*source, "file size",
                   bad_data("expected " + std::to_string(decoded->file_bytes()) +
                            " bytes as the header says, found " + std::to_string(*size)));
  }
  return bytes;
}

Status PackReader::State::open() {
  const auto start = read_start();
  if (!start) return start.error();
  header = *decode_header(std::span(*start).first(kPackHeaderBytes));
  auto opened = PackIndex::open(*source, header, std::span(*start).subspan(kPackHeaderBytes));
  if (!opened) return opened.error();
  index = std::move(*opened);
  for (const PackLevel& level : index->levels()) {
    auto& range = levels[static_cast<std::size_t>(level.layer)];
    if (!range) range = LevelRange{level.level, level.level};
    range->finest = level.level;  // the table ascends by level
  }
  return source->is_slow() ? Status() : read_metadata();
}

Status PackReader::State::read_metadata() const {
  const std::lock_guard lock(metadata_mutex);
  if (metadata) return {};
  const auto bytes = read_checked(
      *source, {{header.metadata_offset, header.metadata_bytes}, header.metadata_checksum}, "metadata");
  if (!bytes) return bytes.error();
  metadata.emplace(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  return {};
}

bool PackReader::State::in_block_area(const IndexEntry& entry) const {
  return entry.offset >= kPackStartBytes && entry.offset <= header.index_offset &&
         entry.bytes <= header.index_offset - entry.offset;
}

Result<std::optional<PackIndex::Found>> PackReader::State::look_up(Layer layer, const TileId& id) const {
  if (!is_valid(id)) return std::optional<PackIndex::Found>();
  return index->find(index_key_of(layer, id));
}

// Why the entry's page could not be read. Where it can be read by now, the entry has still none of the tile's
// figures: whoever has it must look the tile up again.
Status PackReader::State::check_readable(const IndexEntry& entry) const {
  if ((entry.flags & kUnreadable) == 0) return {};
  const auto found = look_up(entry.layer, entry.id);
  if (!found) return found.error();
  return in_file(
      *source, name_of(entry),
      failed("expected an index that can be read, found one that could be read at another try only"));
}

// The blocks of the other children of the tile's parent: a reader that needs one needs the others soon.
std::vector<ByteRange> PackReader::State::siblings_of(const IndexEntry& entry) const {
  std::vector<ByteRange> ranges;
  if (!source->is_slow() || entry.id.level == kMinLevel) return ranges;
  std::uint64_t all = entry.bytes;
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const TileId id = child_of(parent_of(entry.id), quadrant);
    if (id == entry.id) continue;
    const auto found = look_up(entry.layer, id);
    if (!found || !*found || (*found)->entry->bytes == 0) continue;
    all += (*found)->entry->bytes;
    if (all > kMostReadAhead) break;
    ranges.push_back({(*found)->entry->offset, (*found)->entry->bytes});
  }
  return ranges;
}

PackReader::PackReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
PackReader::PackReader(PackReader&&) noexcept = default;
PackReader& PackReader::operator=(PackReader&&) noexcept = default;
PackReader::~PackReader() = default;

Result<PackReader> PackReader::open(const std::filesystem::path& path) {
  Result<File> file = File::open_to_read(path);
  if (!file) return file.error();
  return open(std::make_unique<FileSource>(std::move(*file)));
}

Result<PackReader> PackReader::open(std::unique_ptr<const ByteSource> source) {
  auto state = std::make_unique<State>();
  state->source = std::move(source);
  if (const Status status = state->open(); !status) return status.error();
  return PackReader(std::move(state));
}

const std::filesystem::path& PackReader::path() const {
  return state_->source->name();
}

const PackHeader& PackReader::header() const {
  return state_->header;
}

std::string_view PackReader::metadata_json() const {
  if (!state_->read_metadata()) return {};
  return *state_->metadata;
}

Status PackReader::read_metadata() const {
  return state_->read_metadata();
}

std::size_t PackReader::entry_count() const {
  return static_cast<std::size_t>(state_->header.entry_count);
}

IndexEntry PackReader::entry(std::size_t index) const {
  assert(index < entry_count());
  const Result<const IndexEntry*> entry = state_->index->at(index);
  if (entry) return **entry;
  const auto tile = tile_of_key(state_->index->first_key_near(index))
                        .value_or(LayerTile{Layer::heights, {kMinLevel, 0, 0}});
  return unreadable(tile.layer, tile.id);
}

Status PackReader::read_index(const std::function<void(const ByteRange&)>& visit) const {
  return state_->index->read_all([&visit](const ByteRange& range) {
    if (visit) visit(range);
  });
}

std::optional<IndexEntry> PackReader::find(Layer layer, const TileId& id) const {
  const auto found = state_->look_up(layer, id);
  if (!found) return unreadable(layer, id);
  return *found ? std::optional(*(*found)->entry) : std::nullopt;
}

std::optional<std::size_t> PackReader::find_index(Layer layer, const TileId& id) const {
  const auto found = state_->look_up(layer, id);
  if (!found) return std::size_t{0};
  return *found ? std::optional((*found)->ordinal) : std::nullopt;
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

std::span<const PackLevel> PackReader::level_table() const {
  return state_->index->levels();
}

Result<std::vector<std::byte>> PackReader::read_block(const IndexEntry& entry) const {
  if (const Status status = state_->check_readable(entry); !status) return status.error();
  if (entry.bytes == 0) return std::vector<std::byte>();
  const std::string place = name_of(entry);
  if (!state_->in_block_area(entry))
    return in_file(*state_->source, place, bad_data("expected a block among the pack's, found one outside"));
  return read_checked(*state_->source, {{entry.offset, entry.bytes}, entry.checksum}, place + ": block",
                      state_->siblings_of(entry));
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
  if (!tile) return in_file(*state_->source, name_of(entry), tile.error());
  return tile;
}

Result<ObjectTile> PackReader::read_object_tile(const IndexEntry& entry) const {
  assert(entry.layer == Layer::objects);
  const Result<std::vector<std::byte>> block = read_block(entry);
  if (!block) return block.error();
  if (block->empty()) return ObjectTile();
  Result<ObjectTile> tile = decode_object_block(*block);
  if (!tile) return in_file(*state_->source, name_of(entry), tile.error());
  return tile;
}

Result<ObjectModel> PackReader::read_model(std::uint32_t model) const {
  const auto entry = model < kMostModels ? find(Layer::models, model_address(model)) : std::nullopt;
  if (!entry)
    return in_file(*state_->source, "model " + std::to_string(model), bad_data("expected one, found none"));
  const Result<std::vector<std::byte>> block = read_block(*entry);
  if (!block) return block.error();
  Result<ObjectModel> decoded = decode_model_block(*block);
  if (!decoded) return in_file(*state_->source, name_of(*entry), decoded.error());
  return decoded;
}

std::size_t PackReader::model_count() const {
  std::size_t count = 0;
  for (const PackLevel& level : level_table()) {
    if (level.layer == Layer::models) count += static_cast<std::size_t>(level.tiles);
  }
  return count;
}

}  // namespace cairn
