#include "builder/pack/bake_plan.h"

#include <algorithm>

#include "builder/bake/memory_budget.h"
#include "builder/objects/check_objects.h"
#include "builder/objects/object_layer.h"
#include "builder/raster/body_placement.h"
#include "builder/raster/footprint.h"
#include "builder/raster/gdal_name.h"
#include "builder/raster/source_overrides.h"

namespace cairn {
namespace {

// As coarse as the heights, so that the layers are drawn together from afar.
int imagery_top(const BakePlan& layers, const GridOptions& grid) {
  if (grid.top) return std::min(*grid.top, layers.imagery->finest_level());
  const int own = layers.imagery->is_global() ? kMinLevel : std::min(0, layers.imagery->finest_level());
  return layers.plan ? std::min(own, layers.plan->top()) : own;
}

TileTree imagery_tree(const BakePlan& layers, const GridOptions& grid) {
  Footprint wanted;
  if (grid.region) wanted.add(*grid.region);
  const ImageryMosaic& imagery = *layers.imagery;
  const bool everywhere = !grid.region;
  return TileTree(imagery_top(layers, grid), [&imagery, wanted, everywhere](const TileId& id) {
    return everywhere || wanted.overlaps(without_overhang(tile_bounds(id))) ? imagery.native_level(id)
                                                                            : std::nullopt;
  });
}

bool has_gdal_source(const RasterPool& pool) {
  for (std::size_t s = 0; s < pool.size(); ++s)
    if (pool.info(s).format.starts_with("gdal")) return true;
  return false;
}

// EGM96 is a geoid of the Earth.
Status check_datum(const BakePlan& layers, const BuildOptions& options) {
  const bool is_egm96 = layers.heights && layers.heights->datum().datum == VerticalDatum::egm96;
  if (layers.body.is_earth() || !is_egm96) return {};
  return bad_data(options.mosaic.inputs.front().string() + ": vertical datum: expected one of " +
                  layers.body.name + ", found egm96");
}

Result<Body> body_of_sources(const BakePlan& layers) {
  std::vector<const RasterInfo*> infos;
  const auto add = [&infos](const RasterPool& pool) {
    for (std::size_t s = 0; s < pool.size(); ++s) infos.push_back(&pool.info(s));
  };
  if (layers.heights) add(layers.heights->pool());
  if (layers.imagery) add(layers.imagery->pool());
  return common_body(infos);
}

// The layers are baked one after the other, and the heights' sources closed in between.
void share_memory(const BuildOptions& options, int threads, BakePlan& layers) {
  MemoryNeeds needs{threads, options.grid.tile_size, layers.imagery != nullptr, false, false};
  if (layers.heights) {
    needs.with_projected_heights = layers.heights->has_projected_sources();
    needs.with_gdal = has_gdal_source(layers.heights->pool());
  }
  if (layers.imagery) needs.with_gdal = needs.with_gdal || has_gdal_source(layers.imagery->pool());
  const std::size_t cache = cache_within(options.session.memory_bytes, needs);
  if (layers.heights) layers.heights->set_cache_bytes(cache);
  if (layers.imagery) layers.imagery->set_cache_bytes(cache);
}

}  // namespace

GeoBounds BakePlan::bounds() const {
  Footprint all;
  if (heights) all.add(heights->bounds());
  if (imagery) all.add(imagery->bounds());
  return all.bounds();
}

std::vector<std::filesystem::path> files_of(const BuildOptions& options) {
  std::vector<std::filesystem::path> files = options.mosaic.inputs;
  const auto& images = options.imagery.inputs;
  files.insert(files.end(), images.begin(), images.end());
  if (options.mosaic.geoid) files.push_back(*options.mosaic.geoid);
  for (auto& file : files) file = file_of_gdal_name(file).value_or(file);
  for (auto& file : files_of(options.objects)) files.push_back(std::move(file));
  return files;
}

namespace {

// Lays out the trees over the mosaics that are there.
Status lay_out(const BuildOptions& options, int threads, BakePlan& layers) {
  if (layers.heights) {
    auto plan = HeightPlan::make(*layers.heights, options.mosaic, options.heights, options.grid);
    if (!plan) return plan.error();
    layers.plan = std::move(*plan);
    layers.plan->set_tolerances(*layers.heights);
  }
  if (layers.imagery) {
    layers.imagery_tree = imagery_tree(layers, options.grid);
    if (!layers.heights && layers.imagery_tree->leaf_count() == 0)
      return usage_error("region: expected an area that the sources cover, found none");
  }
  auto body = body_of_sources(layers);
  if (!body) return body.error();
  layers.body = std::move(*body);
  if (auto datum = check_datum(layers, options); !datum) return datum.error();
  share_memory(options, threads, layers);
  return {};
}

}  // namespace

Result<BakePlan> plan_bake(const BuildOptions& options, int threads) {
  BakePlan layers;
  if (!options.mosaic.inputs.empty()) {
    auto mosaic = Mosaic::open(options.mosaic, options.grid.tile_size);
    if (!mosaic) return mosaic.error();
    layers.heights = std::move(*mosaic);
  }
  if (!options.objects.places.empty() && !layers.heights)
    return usage_error("objects: expected DEMs, on whose ground they stand, found none");
  if (auto status = check_objects(options.objects); !status) return status.error();
  if (!options.imagery.inputs.empty()) {
    auto mosaic = ImageryMosaic::open(options.imagery, options.grid.tile_size - 1);
    if (!mosaic) return mosaic.error();
    layers.imagery = std::move(*mosaic);
  }
  if (auto status = lay_out(options, threads, layers); !status) return status.error();
  return layers;
}

Result<BakePlan> plan_bake(KnownSources sources, const BuildOptions& options, int threads) {
  BakePlan layers;
  if (!sources.dems.empty()) {
    OpenOptions open;
    open.rules = options.mosaic.source_rules;
    for (RasterInfo& info : sources.dems) info.overrides = overrides_of(info.path, open.rules);
    auto pool = RasterPool::describe(std::move(sources.dems), std::move(sources.dems_available), open,
                                     RasterPool::Content::heights);
    auto mosaic =
        Mosaic::over(std::move(pool), options.mosaic, options.grid.tile_size, sources.geoid_available);
    if (!mosaic) return mosaic.error();
    layers.heights = std::move(*mosaic);
  }
  if (!sources.images.empty()) {
    const OpenOptions open{.bounds = options.imagery.bounds, .rules = options.imagery.source_rules};
    for (RasterInfo& info : sources.images) info.overrides = overrides_of(info.path, open.rules);
    auto pool = RasterPool::describe(std::move(sources.images), std::move(sources.images_available), open,
                                     RasterPool::Content::colours);
    layers.imagery = ImageryMosaic::over(std::move(pool), options.imagery, options.grid.tile_size - 1);
  }
  if (auto status = lay_out(options, threads, layers); !status) return status.error();
  return layers;
}

}  // namespace cairn
