#include "runtime/gl/host_state.h"

namespace cairn::gl {
namespace {

constexpr std::array kSwitches = {GLenum{GL_CULL_FACE},           GLenum{GL_DEPTH_TEST},
                                  GLenum{GL_DEPTH_CLAMP},         GLenum{GL_STENCIL_TEST},
                                  GLenum{GL_FRAMEBUFFER_SRGB},    GLenum{GL_RASTERIZER_DISCARD},
                                  GLenum{GL_POLYGON_OFFSET_FILL}, GLenum{GL_POLYGON_OFFSET_LINE},
                                  GLenum{GL_COLOR_LOGIC_OP},      GLenum{GL_SAMPLE_ALPHA_TO_COVERAGE},
                                  GLenum{GL_SAMPLE_COVERAGE},     GLenum{GL_SAMPLE_MASK},
                                  GLenum{GL_PRIMITIVE_RESTART},   GLenum{GL_PRIMITIVE_RESTART_FIXED_INDEX}};
constexpr GLenum kClipDistances = 8;

/// As a fresh context has them.
struct Store {
  GLenum name;
  GLint fresh;
};
constexpr std::array<Store, 12> kStores = {{{GL_UNPACK_SWAP_BYTES, 0},
                                            {GL_UNPACK_LSB_FIRST, 0},
                                            {GL_UNPACK_ROW_LENGTH, 0},
                                            {GL_UNPACK_IMAGE_HEIGHT, 0},
                                            {GL_UNPACK_SKIP_ROWS, 0},
                                            {GL_UNPACK_SKIP_PIXELS, 0},
                                            {GL_UNPACK_SKIP_IMAGES, 0},
                                            {GL_UNPACK_ALIGNMENT, 4},
                                            {GL_UNPACK_COMPRESSED_BLOCK_WIDTH, 0},
                                            {GL_UNPACK_COMPRESSED_BLOCK_HEIGHT, 0},
                                            {GL_UNPACK_COMPRESSED_BLOCK_DEPTH, 0},
                                            {GL_UNPACK_COMPRESSED_BLOCK_SIZE, 0}}};

void set(GLenum name, bool on) {
  if (on) {
    glEnable(name);
  } else {
    glDisable(name);
  }
}

}  // namespace

HostState::HostState() {
  for (const GLenum name : kSwitches) switches_.push_back({name, glIsEnabled(name) == GL_TRUE});
  for (GLenum i = 0; i < kClipDistances; ++i)
    switches_.push_back({GL_CLIP_DISTANCE0 + i, glIsEnabled(GL_CLIP_DISTANCE0 + i) == GL_TRUE});
  for (const Store& store : kStores) {
    GLint value = 0;
    glGetIntegerv(store.name, &value);
    stores_.push_back({store.name, value});
  }
  for (GLuint i = 0; i < kUnits; ++i) {
    glGetIntegeri_v(GL_TEXTURE_BINDING_2D_ARRAY, i, &units_[i].texture);
    glGetIntegeri_v(GL_SAMPLER_BINDING, i, &units_[i].sampler);
  }
  glGetIntegerv(GL_SHADER_STORAGE_BUFFER_BINDING, &storage_binding_);
  for (GLuint i = 0; i < kStorages; ++i) {
    glGetIntegeri_v(GL_SHADER_STORAGE_BUFFER_BINDING, i, &storages_[i].buffer);
    glGetInteger64i_v(GL_SHADER_STORAGE_BUFFER_START, i, &storages_[i].start);
    glGetInteger64i_v(GL_SHADER_STORAGE_BUFFER_SIZE, i, &storages_[i].size);
  }
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &draw_framebuffer_);
  glGetFloati_v(GL_VIEWPORT, 0, viewport_.data());
  glGetDoublei_v(GL_DEPTH_RANGE, 0, depth_range_.data());
  glGetIntegerv(GL_CLIP_ORIGIN, &clip_origin_);
  glGetIntegerv(GL_CLIP_DEPTH_MODE, &clip_depth_);
  glGetIntegerv(GL_DEPTH_FUNC, &depth_function_);
  glGetBooleanv(GL_DEPTH_WRITEMASK, &depth_mask_);
  for (GLuint i = 0; i < kTargets; ++i) glGetBooleani_v(GL_COLOR_WRITEMASK, i, colour_masks_[i].data());
  blends_ = glIsEnabledi(GL_BLEND, 0);
  has_scissor_ = glIsEnabledi(GL_SCISSOR_TEST, 0);
  glGetIntegerv(GL_POLYGON_MODE, polygon_mode_.data());
  glGetIntegerv(GL_CURRENT_PROGRAM, &program_);
  glGetIntegerv(GL_PROGRAM_PIPELINE_BINDING, &pipeline_);
  glGetIntegerv(GL_VERTEX_ARRAY_BINDING, &vertex_array_);
  glGetIntegerv(GL_DRAW_INDIRECT_BUFFER_BINDING, &indirect_buffer_);
  glGetIntegerv(GL_PIXEL_UNPACK_BUFFER_BINDING, &unpack_buffer_);

  for (const Switch& each : switches_) glDisable(each.name);
  for (const Store& store : kStores) glPixelStorei(store.name, store.fresh);
  for (GLuint i = 0; i < kUnits; ++i) glBindSampler(i, 0);
  glDepthMask(GL_TRUE);
  glDisablei(GL_BLEND, 0);
  glDisablei(GL_SCISSOR_TEST, 0);
  // What the shaders do not write to other attachments would be undefined there.
  for (GLuint i = 0; i < kTargets; ++i) {
    const GLboolean is_written = i == 0 ? GL_TRUE : GL_FALSE;
    glColorMaski(i, is_written, is_written, is_written, is_written);
  }
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
}

HostState::~HostState() {
  for (const Switch& each : switches_) set(each.name, each.was_on);
  for (const StoreValue& store : stores_) glPixelStorei(store.name, store.value);
  for (GLuint i = 0; i < kUnits; ++i) {
    const GLuint texture = static_cast<GLuint>(units_[i].texture);
    // Zero would unbind the unit's textures of every kind.
    if (texture != 0) {
      glBindTextureUnit(i, texture);
    } else {
      GLint active = 0;
      glGetIntegerv(GL_ACTIVE_TEXTURE, &active);
      glActiveTexture(GL_TEXTURE0 + i);
      glBindTexture(GL_TEXTURE_2D_ARRAY, 0);
      glActiveTexture(static_cast<GLenum>(active));
    }
    glBindSampler(i, static_cast<GLuint>(units_[i].sampler));
  }
  for (GLuint i = 0; i < kStorages; ++i) {
    const auto storage = static_cast<GLuint>(storages_[i].buffer);
    if (storage != 0 && storages_[i].size > 0) {
      glBindBufferRange(GL_SHADER_STORAGE_BUFFER, i, storage, static_cast<GLintptr>(storages_[i].start),
                        static_cast<GLsizeiptr>(storages_[i].size));
    } else {
      glBindBufferBase(GL_SHADER_STORAGE_BUFFER, i, storage);
    }
  }
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, static_cast<GLuint>(storage_binding_));
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(draw_framebuffer_));
  glViewportIndexedfv(0, viewport_.data());
  glDepthRangeIndexed(0, depth_range_[0], depth_range_[1]);
  glClipControl(static_cast<GLenum>(clip_origin_), static_cast<GLenum>(clip_depth_));
  glDepthFunc(static_cast<GLenum>(depth_function_));
  glDepthMask(depth_mask_);
  for (GLuint i = 0; i < kTargets; ++i) {
    const auto& mask = colour_masks_[i];
    glColorMaski(i, mask[0], mask[1], mask[2], mask[3]);
  }
  if (blends_) glEnablei(GL_BLEND, 0);
  if (has_scissor_) glEnablei(GL_SCISSOR_TEST, 0);
  glPolygonMode(GL_FRONT_AND_BACK, static_cast<GLenum>(polygon_mode_[0]));
  glUseProgram(static_cast<GLuint>(program_));
  glBindProgramPipeline(static_cast<GLuint>(pipeline_));
  glBindVertexArray(static_cast<GLuint>(vertex_array_));
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, static_cast<GLuint>(indirect_buffer_));
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, static_cast<GLuint>(unpack_buffer_));
}

}  // namespace cairn::gl
