#include "format/gdal/pack_dataset.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <string>
#include <utility>

namespace cairn {
namespace {

constexpr int kBlockPixels = 256;
constexpr std::size_t kLeastTiles = 8;

/// As many tiles as two rows of blocks touch, so that each is decoded about once while rows are read in
/// order.
std::size_t tiles_for(const PackReader& pack, const RasterGrid& grid) {
  const auto across = static_cast<std::size_t>(grid.columns / (pack.header().tile_size - 1) + 2);
  return std::clamp<std::size_t>(2 * across, kLeastTiles, 128);
}

CPLErr report(const Error& error) {
  CPLError(CE_Failure, error.code == ErrorCode::bad_data ? CPLE_AppDefined : CPLE_FileIO, "%s",
           error.message.c_str());
  return CE_Failure;
}

/// What the bands of both layers have in common.
class PackBand : public GDALPamRasterBand {
 public:
  PackBand(PackDataset* dataset, int band, GDALDataType type) {
    poDS = dataset;
    nBand = band;
    eDataType = type;
    nRasterXSize = dataset->GetRasterXSize();
    nRasterYSize = dataset->GetRasterYSize();
    nBlockXSize = kBlockPixels;
    nBlockYSize = kBlockPixels;
  }

  int GetOverviewCount() override {
    const int own = static_cast<int>(dataset().overviews().size());
    return own > 0 ? own : GDALPamRasterBand::GetOverviewCount();
  }
  GDALRasterBand* GetOverview(int i) override {
    const auto& overviews = dataset().overviews();
    if (overviews.empty()) return GDALPamRasterBand::GetOverview(i);
    if (i < 0 || static_cast<std::size_t>(i) >= overviews.size()) return nullptr;
    return overviews[static_cast<std::size_t>(i)]->GetRasterBand(nBand);
  }

 protected:
  PackDataset& dataset() const { return *static_cast<PackDataset*>(poDS); }

  /// Calls fill(place, index in the block) for each pixel of the block that lies in the raster.
  template <class Fill>
  CPLErr for_each_pixel(int block_column, int block_row, const Fill& fill) {
    const RasterGrid& grid = dataset().grid();
    const int first_column = block_column * kBlockPixels, first_row = block_row * kBlockPixels;
    const int columns = std::min(kBlockPixels, grid.columns - first_column);
    const int rows = std::min(kBlockPixels, grid.rows - first_row);
    try {
      for (int r = 0; r < rows; ++r) {
        const double lat = std::clamp(grid.lat_of(first_row + r), -90.0, 90.0);
        for (int c = 0; c < columns; ++c) {
          const Status status = fill(LonLat{grid.lon_of(first_column + c), lat},
                                     static_cast<std::size_t>(r * kBlockPixels + c));
          if (!status) return report(status.error());
        }
      }
      return CE_None;
    } catch (const std::exception& error) {  // out of memory, at worst; nothing is thrown into GDAL
      return report(failed(error.what()));
    }
  }
};

class HeightBand final : public PackBand {
 public:
  explicit HeightBand(PackDataset* dataset) : PackBand(dataset, 1, GDT_Float32) {
    GDALPamRasterBand::SetDescription("height");
  }

  double GetNoDataValue(int* is_set) override {
    if (is_set != nullptr) *is_set = TRUE;
    return kNoHeight;
  }
  const char* GetUnitType() override { return "m"; }

 protected:
  CPLErr IReadBlock(int column, int row, void* block) override {
    auto* metres = static_cast<float*>(block);
    return for_each_pixel(column, row, [&](LonLat place, std::size_t i) -> Status {
      const auto height = dataset().heights().height_at(place, dataset().grid().level);
      if (!height) return height.error();
      metres[i] = static_cast<float>(*height ? (*height)->metres : kNoHeight);
      return {};
    });
  }
};

class ColourBand final : public PackBand {
 public:
  ColourBand(PackDataset* dataset, int band) : PackBand(dataset, band, GDT_Byte) {}

  GDALColorInterp GetColorInterpretation() override {
    constexpr std::array channels{GCI_RedBand, GCI_GreenBand, GCI_BlueBand, GCI_AlphaBand};
    return channels[static_cast<std::size_t>(nBand - 1)];
  }

 protected:
  CPLErr IReadBlock(int column, int row, void* block) override {
    PackDataset::ColourBlock& colours = dataset().last_block();
    if (colours.column != column || colours.row != row) {
      colours.column = -1;  // until it is whole
      colours.pixels.resize(std::size_t{kBlockPixels} * kBlockPixels);
      const CPLErr error = for_each_pixel(column, row, [&](LonLat place, std::size_t i) -> Status {
        const auto colour = dataset().imagery().colour_at(place, dataset().grid().level);
        if (!colour) return colour.error();
        colours.pixels[i] = *colour;
        return {};
      });
      if (error != CE_None) return error;
      colours.column = column;
      colours.row = row;
    }
    const auto channel = static_cast<std::size_t>(nBand - 1);
    std::transform(colours.pixels.begin(), colours.pixels.end(), static_cast<std::uint8_t*>(block),
                   [channel](const ImagerySampler::Colour& colour) { return colour[channel]; });
    return CE_None;
  }
};

const char* earth_crs_of(Layer layer, VerticalDatum datum) {
  if (layer == Layer::imagery) return "EPSG:4326";
  switch (datum) {
    case VerticalDatum::egm96:
      return "EPSG:4326+5773";
    case VerticalDatum::ellipsoid:
      return "EPSG:4979";
    case VerticalDatum::unknown:
      break;
  }
  return "EPSG:4326";
}

OGRSpatialReference crs_of(Layer layer, const PackHeader& header) {
  OGRSpatialReference crs;
  const Body& body = header.body;
  if (body == Body()) {
    crs.SetFromUserInput(earth_crs_of(layer, header.vertical_datum));
  } else {
    const double flattening = body.shape.flattening();
    // Only the name can say that latitudes are planetographic.
    const std::string name = body.name + (flattening > 0 ? " / Ographic" : "");
    crs.SetGeogCS(name.c_str(), body.name.c_str(), body.name.c_str(), body.shape.semi_major_m,
                  flattening > 0 ? 1 / flattening : 0, "Reference meridian", 0);
  }
  crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return crs;
}

}  // namespace

PackDataset::PackDataset(std::shared_ptr<const PackReader> pack, Layer layer, std::vector<RasterGrid> grids)
    : pack_(std::move(pack)),
      grid_(grids.front()),
      heights_(*pack_, tiles_for(*pack_, grid_)),
      imagery_(*pack_, tiles_for(*pack_, grid_)) {
  nRasterXSize = grid_.columns;
  nRasterYSize = grid_.rows;
  crs_ = crs_of(layer, pack_->header());
  if (layer == Layer::heights) {
    SetBand(1, new HeightBand(this));
  } else {
    for (int band = 1; band <= 4; ++band) SetBand(band, new ColourBand(this, band));
    GDALDataset::SetMetadataItem("INTERLEAVE", "PIXEL", "IMAGE_STRUCTURE");
  }
  for (std::size_t i = 1; i < grids.size(); ++i)
    overviews_.push_back(std::make_unique<PackDataset>(pack_, layer, std::vector{grids[i]}));
}

CPLErr PackDataset::GetGeoTransform(double* transform) {
  const auto own = grid_.geo_transform();
  std::copy(own.begin(), own.end(), transform);
  return CE_None;
}

const OGRSpatialReference* PackDataset::GetSpatialRef() const {
  return &crs_;
}

void PackDataset::load_side_file(const char* opened, const DatasetName& name) {
  SetDescription(opened);
  if (name.layer) {
    SetPhysicalFilename(name.file.c_str());
    SetSubdatasetName(to_string(*name.layer));
  }
  TryLoadXML();
}

}  // namespace cairn
