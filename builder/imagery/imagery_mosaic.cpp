#include "builder/imagery/imagery_mosaic.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "builder/imagery/image_resample.h"
#include "builder/imagery/texel_loops.h"
#include "builder/raster/raster_placement.h"

namespace cairn {

// Images laid under one another. Each adds what those above leave open; feathering takes weight from an image
// near its rim, so at the end all weights are raised to what the images cover.
class ImageStack {
 public:
  ImageStack(const TexelWindow& window, double feather) : window_(window), feather_(feather) {}

  bool is_full() const {
    if (only_) return only_->is_opaque && fills_window(only_->texels);
    return !open_.empty() && std::all_of(open_.begin(), open_.end(), [](float open) { return open <= 0; });
  }

  void add(ResampledImage&& image) {
    if (!image.texels.is_set()) return;
    if (feather_ == 0 && !only_ && sum_.empty()) {
      only_ = std::move(image);
      return;
    }
    make_room();
    blend(image);
  }

  LinearImage finish() {
    if (only_) return placed(std::move(*only_));
    LinearImage image(window_.columns, window_.rows);
    for (std::size_t i = 0; i < sum_.size(); ++i) {
      const float covered = kOne * (1 - bare_[i]);
      if (!(sum_[i][3] > 0)) continue;
      const float raise = sum_[i][3] < covered ? covered / sum_[i][3] : 1.0F;
      const auto columns = static_cast<std::size_t>(window_.columns);
      LinearTexel& texel = image.row(static_cast<int>(i / columns))[i % columns];
      for (std::size_t k = 0; k < 4; ++k)
        texel[k] = static_cast<std::uint16_t>(std::min(kOne, sum_[i][static_cast<int>(k)] * raise + 0.5F));
    }
    return image;
  }

 private:
  static constexpr float kOne = 65535;

  bool fills_window(const LinearImage& image) const {
    return image.columns == window_.columns && image.rows == window_.rows;
  }

  LinearImage placed(ResampledImage&& image) const {
    if (fills_window(image.texels)) return std::move(image.texels);
    LinearImage whole(window_.columns, window_.rows);
    for (int r = 0; r < image.texels.rows; ++r)
      std::copy_n(image.texels.row(r), image.texels.columns, whole.row(image.row + r) + image.column);
    return whole;
  }

  void make_room() {
    if (!sum_.empty()) return;
    const auto count = static_cast<std::size_t>(window_.columns) * static_cast<std::size_t>(window_.rows);
    sum_.resize(count);
    open_.assign(count, 1.0F);
    bare_.assign(count, 1.0F);
    if (only_) blend(*std::exchange(only_, std::nullopt));
  }

  void blend(const ResampledImage& image) {
    for (int r = 0; r < image.texels.rows; ++r) {
      const auto from = static_cast<std::size_t>(r * image.texels.columns);
      const float* rims = image.rims.empty() ? nullptr : &image.rims[from];
      add_row(image.texels.row(r), rims, image.texels.columns,
              static_cast<std::size_t>((image.row + r) * window_.columns + image.column));
    }
  }

  void add_row(const LinearTexel* texels, const float* rims, int count, std::size_t to) {
    for (int c = 0; c < count; ++c, ++to) {
      const LinearTexel& texel = texels[c];
      if (texel[3] == 0) continue;
      const float fade = feather_ > 0 ? std::min(1.0F, rims[c] / static_cast<float>(feather_)) : 1.0F;
      const float alpha = texel[3] / kOne;
      const FloatTexel wide{static_cast<float>(texel[0]), static_cast<float>(texel[1]),
                            static_cast<float>(texel[2]), static_cast<float>(texel[3])};
      sum_[to] += wide * (open_[to] * fade);
      open_[to] *= 1 - alpha * fade;
      bare_[to] *= 1 - alpha;
    }
  }

  TexelWindow window_;
  double feather_;                      // pixels
  std::optional<ResampledImage> only_;  // the topmost image, until there is another or where it fades
  std::vector<FloatTexel> sum_;
  std::vector<float> open_;  // share that shows what lies beneath
  std::vector<float> bare_;  // the same without feathering
};

namespace {

constexpr std::array<double, 3> kTurns = {0.0, -360.0, 360.0};

// Pixels a degree in the raster's middle, along the denser axis.
double density_of(const RasterInfo& info) {
  const double c = static_cast<double>(info.columns) / 2, r = static_cast<double>(info.rows) / 2;
  const LonLat middle = info.georeference.place_of(c, r);
  constexpr double kStep = 1e-6;
  const auto along = [&](LonLat end) {
    const auto a = info.georeference.post_at(middle), b = info.georeference.post_at(end);
    return std::hypot(b.column - a.column, b.row - a.row) / kStep;
  };
  if (info.georeference.crs == Georeference::Crs::geographic && info.georeference.is_straight())
    return 1 / std::min(std::abs(info.georeference.dx), std::abs(info.georeference.dy));
  return std::max(along({middle.lon + kStep, middle.lat}), along({middle.lon, middle.lat + kStep}));
}

// A hair of tolerance: 1024.0000001 pixels are 1024, and so are those of a projection's rounding.
int level_for(double pixels_per_degree, int size) {
  int level = kMinLevel;
  while (level < kMaxLevel && size / tile_width_degrees(level) < pixels_per_degree * (1 - 1e-7)) ++level;
  return level;
}

// Pixels are areas: half a pixel more than between the posts.
Footprint outline_of(const RasterInfo& info) {
  const double columns = static_cast<double>(info.columns), rows = static_cast<double>(info.rows);
  const GeoBounds& b = info.bounds;
  const double x = b.width() / (columns - 1) / 2, y = b.height() / (rows - 1) / 2;
  Footprint outline;
  for (const GeoBounds& part : tight_bounds(info, 3))
    outline.add(
        {part.west - x, std::max(-90.0, part.south - y), part.east + x, std::min(90.0, part.north + y)});
  return outline;
}

// Where tiles overhang the world there is nothing.
void clear_overhang(const TexelWindow& window, int size, LinearImage& image) {
  const bool wraps = std::fmod(360 * window.texels_per_degree, size) == 0;
  const GeoBounds b = window.bounds();
  if (b.south >= -90 && b.north <= 90 && (wraps || (b.west >= -180 && b.east <= 180))) return;
  for (int r = 0; r < image.rows; ++r) {
    const double lat = window.lat_of(r);
    for (int c = 0; c < image.columns; ++c) {
      const double lon = window.lon_of(c);
      if (lat < -90 || lat > 90 || (!wraps && (lon < -180 || lon > 180))) image.row(r)[c] = {};
    }
  }
}

}  // namespace

ImageryMosaic::Image ImageryMosaic::describe(std::size_t source) const {
  const RasterInfo& info = pool_->info(source);
  Image image{source, outline_of(info), density_of(info), 0};
  image.level = level_for(image.pixels_per_degree, size_);
  return image;
}

Result<std::unique_ptr<ImageryMosaic>> ImageryMosaic::open(const ImageryOptions& options, int size) {
  auto pool = RasterPool::open(options.inputs, {.bounds = options.bounds, .rules = options.source_rules},
                               RasterPool::Content::colours);
  if (!pool) return pool.error();
  return over(std::move(*pool), options, size);
}

std::unique_ptr<ImageryMosaic> ImageryMosaic::over(std::unique_ptr<RasterPool> pool,
                                                   const ImageryOptions& options, int size) {
  std::unique_ptr<ImageryMosaic> mosaic(new ImageryMosaic);
  mosaic->size_ = size;
  mosaic->feather_pixels_ = options.feather_pixels;
  mosaic->pool_ = std::move(pool);
  for (std::size_t s = 0; s < mosaic->pool_->size(); ++s) mosaic->images_.push_back(mosaic->describe(s));
  std::stable_sort(mosaic->images_.begin(), mosaic->images_.end(), [](const Image& a, const Image& b) {
    return a.pixels_per_degree > b.pixels_per_degree * (1 + 1e-6);
  });
  return mosaic;
}

// What sample() and native_level() ask of an image, and a little more.
std::vector<std::size_t> ImageryMosaic::sources_near(const GeoBounds& area) const {
  std::vector<std::size_t> found;
  for (const Image& image : images_) {
    const double margin = 1 / image.pixels_per_degree;
    const GeoBounds b = image.outline.bounds();
    const bool around = b.width() > 360 - margin;
    const bool near = std::any_of(kTurns.begin(), kTurns.end(), [&](double turn) {
      return b.touches(
          {area.west + turn - margin, area.south - margin, area.east + turn + margin, area.north + margin});
    });
    if (around || near) found.push_back(image.source);
  }
  return found;
}

GeoBounds ImageryMosaic::bounds() const {
  Footprint all;
  for (const Image& image : images_) all.add(image.outline.bounds());
  return all.bounds();
}

bool ImageryMosaic::is_global() const {
  return std::any_of(images_.begin(), images_.end(), [](const Image& image) {
    const GeoBounds b = image.outline.bounds();
    return b.width() >= 360 - 2 / image.pixels_per_degree && b.height() >= 180 - 2 / image.pixels_per_degree;
  });
}

int ImageryMosaic::finest_level() const {
  int finest = kMinLevel;
  for (const Image& image : images_) finest = std::max(finest, image.level);
  return finest;
}

std::optional<int> ImageryMosaic::native_level(const TileId& id) const {
  std::optional<int> finest;
  for (const Image& image : images_) {
    if (image.outline.overlaps(without_overhang(tile_bounds(id))))
      finest = std::max(finest.value_or(kMinLevel), image.level);
  }
  return finest;
}

Status ImageryMosaic::lay(const Image& image, const TexelWindow& window, double turn,
                          ImageStack& stack) const {
  const auto source = pool_->acquire(image.source);
  if (!source) return source.error();
  auto resampled = resample_image(**source, window, turn, feather_pixels_ > 0);
  if (!resampled) return resampled.error();
  stack.add(std::move(*resampled));
  return {};
}

Result<LinearImage> ImageryMosaic::sample(const TexelWindow& window) const {
  ImageStack stack(window, feather_pixels_);
  for (const Image& image : images_) {
    for (const double turn : kTurns) {
      GeoBounds turned = window.bounds();
      turned.west += turn;
      turned.east += turn;
      const GeoBounds b = image.outline.bounds();
      const bool around = b.width() > 360 - 1 / image.pixels_per_degree;
      if (around ? turn != 0 : !b.touches(turned)) continue;
      if (auto status = lay(image, window, turn, stack); !status) return status.error();
    }
    if (stack.is_full()) break;
  }
  LinearImage sampled = stack.finish();
  clear_overhang(window, size_, sampled);
  return sampled;
}

}  // namespace cairn
