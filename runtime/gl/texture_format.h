#pragma once

#include <epoxy/gl.h>

#include "cairn/texture_tile.h"

namespace cairn::gl {

/// Returns OpenGL's name of a block format whose colours are sRGB.
inline GLenum srgb_format(TextureFormat format) {
  switch (format) {
    case TextureFormat::bc1:
      return GL_COMPRESSED_SRGB_ALPHA_S3TC_DXT1_EXT;
    case TextureFormat::bc3:
      return GL_COMPRESSED_SRGB_ALPHA_S3TC_DXT5_EXT;
    default:
      return GL_COMPRESSED_SRGB_ALPHA_BPTC_UNORM;
  }
}

/// Returns whether this context reads textures of the format.
inline bool can_read(TextureFormat format) {
  if (format == TextureFormat::bc7) return epoxy_has_gl_extension("GL_ARB_texture_compression_bptc");
  return epoxy_has_gl_extension("GL_EXT_texture_compression_s3tc") &&
         (epoxy_has_gl_extension("GL_EXT_texture_sRGB") ||
          epoxy_has_gl_extension("GL_EXT_texture_compression_s3tc_srgb"));
}

}  // namespace cairn::gl
