#pragma once

#include "cairn/grid_options.h"
#include "cairn/height_options.h"
#include "cairn/imagery_options.h"
#include "cairn/mosaic_options.h"
#include "cairn/object_options.h"
#include "cairn/session_options.h"

namespace cairn {

/// What a bake is asked for, by stage. The defaults are the program's.
struct BuildOptions {
  GridOptions grid;
  MosaicOptions mosaic;
  HeightOptions heights;
  ImageryOptions imagery;
  ObjectOptions objects;
  SessionOptions session;
};

}  // namespace cairn
