#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "builder/imagery/linear_image.h"
#include "builder/imagery/texel_window.h"
#include "builder/raster/footprint.h"
#include "builder/raster/raster_pool.h"
#include "cairn/imagery_options.h"

namespace cairn {

/// All images of a bake as one picture: finer ones lie on top, then those named earlier.
class ImageryMosaic {
 public:
  /// Tiles have `size` texels a side.
  static Result<std::unique_ptr<ImageryMosaic>> open(const ImageryOptions& options, int size);

  /// open() of images that were looked at before: `options.inputs` do not count.
  static std::unique_ptr<ImageryMosaic> over(std::unique_ptr<RasterPool> pool, const ImageryOptions& options,
                                             int size);

  /// What may be kept of the sources. Before any sample() only.
  void set_cache_bytes(std::size_t bytes) { pool_->set_cache_bytes(bytes); }

  const RasterPool& pool() const { return *pool_; }
  GeoBounds bounds() const;  ///< of the outer edges of all images
  bool is_global() const;
  int finest_level() const;

  /// The finest level that any image needs that touches the tile: the first whose texels are no larger than
  /// its pixels. nullopt where none touches it. It may be coarser than the tile.
  std::optional<int> native_level(const TileId& id) const;

  /// The images that texels of the area can depend on, by number in the pool, the topmost first.
  std::vector<std::size_t> sources_near(const GeoBounds& area) const;

  /// Safe to call from several threads.
  Result<LinearImage> sample(const TexelWindow& window) const;

 private:
  struct Image {
    std::size_t source = 0;  // in the pool
    Footprint outline;       // of its pixels' outer edges, or a little more
    double pixels_per_degree = 0;
    int level = 0;
  };

  ImageryMosaic() = default;
  Image describe(std::size_t source) const;
  Status lay(const Image& image, const TexelWindow& window, double turn, class ImageStack& stack) const;

  int size_ = 512;
  double feather_pixels_ = 0;
  std::unique_ptr<RasterPool> pool_;
  std::vector<Image> images_;  // the topmost first
};

}  // namespace cairn
