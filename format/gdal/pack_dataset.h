#pragma once

#include <memory>
#include <string>
#include <vector>

#include <gdal_pam.h>
#include <ogr_spatialref.h>

#include "cairn/pack_reader.h"
#include "cairn/pack_sampler.h"
#include "format/gdal/dataset_name.h"
#include "format/gdal/raster_grid.h"
#include "format/imagery_sampler.h"

namespace cairn {

/// A layer of a pack at one level as a GDAL dataset; its overviews are datasets of coarser levels. Heights
/// are one Float32 band in metres, imagery four Byte bands.
class PackDataset final : public GDALPamDataset {
 public:
  /// `grids` are the dataset's own, then those of its overviews. REQUIRES: layer is heights or imagery.
  PackDataset(std::shared_ptr<const PackReader> pack, Layer layer, std::vector<RasterGrid> grids);

  CPLErr GetGeoTransform(double* transform) override;
  const OGRSpatialReference* GetSpatialRef() const override;

  /// Reads what GDAL keeps beside the pack (FILE.aux.xml), such as statistics. `opened` is the name that GDAL
  /// was given.
  void load_side_file(const char* opened, const DatasetName& name);

  const RasterGrid& grid() const { return grid_; }
  const std::vector<std::unique_ptr<PackDataset>>& overviews() const { return overviews_; }
  PackSampler& heights() { return heights_; }
  ImagerySampler& imagery() { return imagery_; }

  /// The block that was drawn last, since GDAL asks for it band by band.
  struct ColourBlock {
    int column = -1;  ///< -1: none
    int row = -1;
    std::vector<ImagerySampler::Colour> pixels;
  };
  ColourBlock& last_block() { return last_block_; }

 private:
  std::shared_ptr<const PackReader> pack_;
  RasterGrid grid_;
  PackSampler heights_;
  ImagerySampler imagery_;
  ColourBlock last_block_;
  OGRSpatialReference crs_;
  std::vector<std::unique_ptr<PackDataset>> overviews_;
};

/// A height in a dataset's band where the pack has none.
inline constexpr double kNoHeight = -32768;

}  // namespace cairn
