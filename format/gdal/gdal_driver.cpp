// The GDAL driver CAIRN: packs as rasters for gdalinfo, QGIS, rasterio and all else that reads through GDAL.
// GDAL loads it as the plug-in gdal_CAIRN.so.

#include <algorithm>
#include <cstring>
#include <exception>
#include <memory>
#include <string>

#include <gdal_frmts.h>
#include <gdal_priv.h>

#include "cairn/pack_reader.h"
#include "format/gdal/dataset_name.h"
#include "format/gdal/pack_dataset.h"
#include "format/gdal/pack_facts.h"
#include "format/gdal/raster_grid.h"
#include "format/gdal/vsi_source.h"

namespace cairn {
namespace {

int identify(GDALOpenInfo* info) {
  if (STARTS_WITH_CI(info->pszFilename, "CAIRN:")) return TRUE;
  return info->nHeaderBytes >= static_cast<int>(kPackMagic.size()) &&
         std::memcmp(info->pabyHeader, kPackMagic.data(), kPackMagic.size()) == 0;
}

/// The layers of a pack that are rasters.
std::vector<Layer> layers_of(const PackReader& pack) {
  std::vector<Layer> layers;
  for (const Layer layer : {Layer::heights, Layer::imagery})
    if (pack.levels(layer)) layers.push_back(layer);
  return layers;
}

Result<int> level_of(const PackReader& pack, Layer layer, const DatasetName& name) {
  const auto range = pack.levels(layer);
  const int level = name.level.value_or(range->finest);
  if (level >= range->coarsest && level <= range->finest) return level;
  return bad_data(name.file + ": " + to_string(layer) + ": expected a level of " +
                  std::to_string(range->coarsest) + " to " + std::to_string(range->finest) + ", found " +
                  std::to_string(level));
}

/// Lists the layers, where there are several and none was asked for.
void list_subdatasets(GDALDataset& dataset, const std::string& file, const std::vector<Layer>& layers) {
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const std::string key = "SUBDATASET_" + std::to_string(i + 1);
    const std::string what = layers[i] == Layer::heights ? "heights in metres" : "imagery, RGBA";
    dataset.GDALDataset::SetMetadataItem((key + "_NAME").c_str(), subdataset_name(file, layers[i]).c_str(),
                                         "SUBDATASETS");
    dataset.GDALDataset::SetMetadataItem((key + "_DESC").c_str(), (what + " of " + file).c_str(),
                                         "SUBDATASETS");
  }
}

/// Opens a file of this machine, or of GDAL's own file systems.
Result<PackReader> open_file(const std::string& file) {
  if (!file.starts_with("/vsi")) return PackReader::open(file);
  auto source = open_vsi_source(file);
  if (!source) return source.error();
  return PackReader::open(*std::move(source));
}

Result<std::unique_ptr<PackDataset>> open_dataset(const DatasetName& name) {
  auto opened = open_file(name.file);
  if (!opened) return opened.error();
  const auto pack = std::make_shared<const PackReader>(*std::move(opened));
  const std::vector<Layer> layers = layers_of(*pack);
  if (layers.empty()) return bad_data(name.file + ": expected heights or imagery, found neither");
  const Layer layer = name.layer.value_or(layers.front());
  if (!pack->levels(layer))
    return bad_data(name.file + ": expected " + to_string(layer) + ", the pack has none");
  const auto metadata = read_metadata(*pack);
  if (!metadata) return metadata.error();
  const auto bounds = bounds_of(*pack, *metadata, layer);
  if (!bounds) return bounds.error();
  const auto level = level_of(*pack, layer, name);
  if (!level) return level.error();
  const auto grids = raster_grids(*pack, layer, *bounds, *level);
  if (!grids) return grids.error();
  auto dataset = std::make_unique<PackDataset>(pack, layer, *grids);
  set_metadata_items(*dataset, *pack, *metadata, layer, *level);
  if (!name.layer && layers.size() > 1) list_subdatasets(*dataset, name.file, layers);
  return dataset;
}

GDALDataset* open(GDALOpenInfo* info) {
  if (identify(info) == FALSE) return nullptr;
  if (info->eAccess == GA_Update) {
    CPLError(CE_Failure, CPLE_NotSupported, "%s: packs are read only", info->pszFilename);
    return nullptr;
  }
  const auto name = parse_dataset_name(info->pszFilename);
  if (!name) {
    CPLError(CE_Failure, CPLE_OpenFailed, "%s: expected CAIRN:\"FILE\":heights or CAIRN:\"FILE\":imagery",
             info->pszFilename);
    return nullptr;
  }
  try {
    auto dataset = open_dataset(*name);
    if (!dataset) {
      CPLError(CE_Failure, CPLE_OpenFailed, "%s", dataset.error().message.c_str());
      return nullptr;
    }
    (*dataset)->load_side_file(info->pszFilename, *name);
    return dataset->release();
  } catch (const std::exception& error) {  // out of memory, at worst
    CPLError(CE_Failure, CPLE_OutOfMemory, "%s: %s", info->pszFilename, error.what());
    return nullptr;
  }
}

}  // namespace
}  // namespace cairn

extern "C" CPL_DLL void GDALRegister_CAIRN() {
  if (!GDAL_CHECK_VERSION("CAIRN") || GDALGetDriverByName("CAIRN") != nullptr) return;
  auto driver = std::make_unique<GDALDriver>();
  driver->SetDescription("CAIRN");
  driver->SetMetadataItem(GDAL_DCAP_RASTER, "YES");
  driver->SetMetadataItem(GDAL_DMD_LONGNAME, "Terrain pack of cairn");
  driver->SetMetadataItem(GDAL_DMD_EXTENSION, "cairn");
  driver->SetMetadataItem(GDAL_DMD_MIMETYPE, "application/vnd.cairn.pack");
  driver->SetMetadataItem(GDAL_DCAP_VIRTUALIO, "YES");
  driver->SetMetadataItem(GDAL_DMD_SUBDATASETS, "YES");
  driver->pfnIdentify = cairn::identify;
  driver->pfnOpen = cairn::open;
  GetGDALDriverManager()->RegisterDriver(driver.release());
}
