#pragma once

#include <string>

#include "runtime/gl/picture.h"

namespace cairn::test {

/// How different two pictures of one size look: CIE 1976 colour differences of the means of 4×4 pixels, which
/// the eye sees from about 2.3 on.
struct PictureDifference {
  double mean = 0;
  double worst_percent = 0;  ///< the difference that one block of a hundred exceeds
};
PictureDifference difference(const gl::Picture& a, const gl::Picture& b);

/// Reads tests/golden/pictures/NAME.png. With CAIRN_WRITE_GOLDEN set, writes `drawn` there before.
gl::Picture golden_picture(const std::string& name, const gl::Picture& drawn);

}  // namespace cairn::test
