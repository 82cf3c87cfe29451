#include "runtime/gl/object_batch.h"

#include <algorithm>
#include <bit>
#include <span>

#include "runtime/gl/texture_format.h"

namespace cairn::gl {
namespace {

constexpr GLint kViews = 12, kExtent = 13;  // uniforms of object.vert
constexpr GLuint kModelBinding = 0, kInstanceBinding = 1;
constexpr GLuint kFootAttribute = 3, kHeadingAttribute = 4;

void describe_instances(GLuint vertex_array) {
  for (const GLuint location : {kFootAttribute, kHeadingAttribute}) {
    glEnableVertexArrayAttrib(vertex_array, location);
    glVertexArrayAttribBinding(vertex_array, location, kInstanceBinding);
  }
  glVertexArrayAttribFormat(vertex_array, kFootAttribute, 4, GL_FLOAT, GL_FALSE,
                            offsetof(ObjectInstance, from_eye));
  glVertexArrayAttribFormat(vertex_array, kHeadingAttribute, 4, GL_FLOAT, GL_FALSE,
                            offsetof(ObjectInstance, heading));
  glVertexArrayBindingDivisor(vertex_array, kInstanceBinding, 1);
}

/// An array of one layer: what HostState gives back of a unit is its array.
Texture upload_texture(const TextureTile& tile) {
  if (tile.size == 0 || !can_read(tile.format)) return {};
  const int mips = std::bit_width(static_cast<unsigned>(tile.size));
  Texture texture = make_texture(GL_TEXTURE_2D_ARRAY);
  glTextureStorage3D(texture.name(), mips, srgb_format(tile.format), tile.size, tile.size, 1);
  glTextureParameteri(texture.name(), GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTextureParameteri(texture.name(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  const std::byte* texels = tile.texels.data();
  for (int mip = 0; mip < mips; ++mip) {
    const int side = std::max(tile.size >> mip, 1);
    const std::size_t bytes = texture_image_bytes(tile.format, side);
    glCompressedTextureSubImage3D(texture.name(), mip, 0, 0, 0, side, side, 1, srgb_format(tile.format),
                                  static_cast<GLsizei>(bytes), texels);
    texels += bytes;
  }
  return texture;
}

}  // namespace

ObjectBatch::ObjectBatch() {
  const GLuint vao = triangles_.name();
  for (GLuint location = 0; location < 3; ++location) {
    glEnableVertexArrayAttrib(vao, location);
    glVertexArrayAttribBinding(vao, location, kModelBinding);
  }
  glVertexArrayAttribFormat(vao, 0, 3, GL_FLOAT, GL_FALSE, offsetof(ModelVertex, position_m));
  glVertexArrayAttribFormat(vao, 1, 3, GL_FLOAT, GL_FALSE, offsetof(ModelVertex, normal));
  glVertexArrayAttribFormat(vao, 2, 2, GL_FLOAT, GL_FALSE, offsetof(ModelVertex, texture));
  describe_instances(vao);
  describe_instances(billboards_.name());
}

ObjectBatch::Model ObjectBatch::upload(const std::shared_ptr<const ObjectModel>& source) {
  Model model{source,
              make_buffer(),
              make_buffer(),
              upload_texture(source->texture),
              upload_texture(source->billboard),
              0};
  fill<ModelVertex>(model.vertices, source->vertices);
  fill<std::uint16_t>(model.indices, source->indices);
  model.bytes = source->vertices.size() * sizeof(ModelVertex) +
                source->indices.size() * sizeof(std::uint16_t) + source->texture.texels.size() +
                source->billboard.texels.size();
  return model;
}

void ObjectBatch::take(const SurfaceObjects& objects) {
  for (const ObjectDraw& draw : objects.draws) {
    const auto known = models_.find(draw.model.get());
    if (known != models_.end() && !known->second.source.expired()) continue;
    if (known != models_.end()) {  // another model has its address now
      bytes_ -= known->second.bytes;
      models_.erase(known);
    }
    Model model = upload(draw.model);
    bytes_ += model.bytes;
    models_.emplace(draw.model.get(), std::move(model));
  }
  std::erase_if(models_, [this](const auto& item) {
    if (!item.second.source.expired()) return false;
    bytes_ -= item.second.bytes;
    return true;
  });
}

void ObjectBatch::draw(const SurfaceObjects& objects, GLuint program, bool calls) {
  if (objects.draws.empty()) return;
  fill<ObjectInstance>(instances_, objects.instances);
  for (const GLuint vao : {triangles_.name(), billboards_.name()})
    glVertexArrayVertexBuffer(vao, kInstanceBinding, instances_.name(), 0, sizeof(ObjectInstance));
  for (const ObjectDraw& draw : objects.draws) {
    const auto found = models_.find(draw.model.get());
    if (found == models_.end()) continue;
    const Model& model = found->second;
    const bool is_billboard = draw.level == ObjectDraw::kBillboard;
    const Texture& texture = is_billboard ? model.billboard : model.texture;
    if (!texture) continue;
    glProgramUniform1ui(program, kViews,
                        is_billboard ? static_cast<GLuint>(draw.model->billboard_views) : 0u);
    glProgramUniform3f(program, kExtent, draw.model->radius_m, draw.model->bottom_m, draw.model->top_m);
    glBindTextureUnit(0, texture.name());
    if (!calls) continue;
    if (is_billboard) {
      glBindVertexArray(billboards_.name());
      glDrawArraysInstancedBaseInstance(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(draw.count),
                                        draw.first);
      continue;
    }
    glVertexArrayVertexBuffer(triangles_.name(), kModelBinding, model.vertices.name(), 0,
                              sizeof(ModelVertex));
    glVertexArrayElementBuffer(triangles_.name(), model.indices.name());
    glBindVertexArray(triangles_.name());
    const ModelLevel& level = draw.model->levels[static_cast<std::size_t>(draw.level)];
    const std::size_t offset = level.first * sizeof(std::uint16_t);
    glDrawElementsInstancedBaseInstance(GL_TRIANGLES, static_cast<GLsizei>(level.count), GL_UNSIGNED_SHORT,
                                        reinterpret_cast<const void*>(offset),
                                        static_cast<GLsizei>(draw.count), draw.first);
  }
}

}  // namespace cairn::gl
