#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "builder/bake/layer_bake.h"
#include "builder/shard/part_sink.h"
#include "cairn/progress.h"

namespace cairn {

/// A part, and how far it has been read.
struct MergedPart {
  std::filesystem::path path;
  std::uint64_t position = 0;
};

/// Takes a layer's units over from one part.
template <TileLayer L>
Status merge_part(MergedPart& part, const std::vector<TileId>& units, Layer kind, const L& layer,
                  const TileTree& tree, std::uint64_t per_leaf, BakeSession& session, LayerSink<L>& sink,
                  Progress& now, const ProgressCallback& progress) {
  auto reader = PartReader::open_at(part.path, part.position);
  if (!reader) return reader.error();
  for (const TileId& unit : units) {
    auto record = reader->next();
    if (!record) return record.error();
    if (record->layer != kind || record->unit != unit)
      return bad_data(part.path.string() + ": expected the unit " + to_string(kind) + " " + to_string(unit) +
                      ", found " + to_string(record->layer) + " " + to_string(record->unit));
    auto risen = subtree_of(layer, *record);
    if (!risen) return bad_data(part.path.string() + ": " + risen.error().message);
    const Status taken = sink.take_over(
        unit, record->blocks, {{}, std::move(record->held), std::move(record->root)}, std::move(*risen));
    if (!taken) return taken;
    now.done += tree.leaves(unit).size() * per_leaf;
    now.bytes_written = session.writer.position();
    if (!progress(now)) return cancelled(now);
  }
  part.position = reader->position();
  return {};
}

}  // namespace cairn
