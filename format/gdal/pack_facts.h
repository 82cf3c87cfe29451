#pragma once

#include <optional>

#include <cpl_json.h>
#include <gdal_priv.h>

#include "cairn/geo.h"
#include "cairn/pack_reader.h"
#include "cairn/status.h"

namespace cairn {

/// The metadata of a pack, for what GDAL asks of it.
Result<CPLJSONObject> read_metadata(const PackReader& pack);

/// Where the sources of a layer lie. bad_data where the metadata do not say it.
Result<GeoBounds> bounds_of(const PackReader& pack, const CPLJSONObject& metadata, Layer layer);

/// Sets what is known of a layer as metadata items of a dataset: error bound, measured post errors, datum,
/// quantum, the largest error of each level; and the whole metadata in the domain json:cairn.
void set_metadata_items(GDALDataset& dataset, const PackReader& pack, const CPLJSONObject& metadata,
                        Layer layer, int level);

}  // namespace cairn
