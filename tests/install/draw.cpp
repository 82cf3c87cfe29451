// Draws a pack with a renderer of its own over cairn::surface, and compares its depth with that of cairn::gl.
#include <map>

#include <cairn/gl_terrain.h>
#include <cairn/surface.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <glm/gtc/type_ptr.hpp>

constexpr int kWidth = 640, kHeight = 360;

const char* const kVertex = R"(#version 450
layout(location = 0) in vec3 high;
layout(location = 1) in vec3 low;
layout(location = 2) in float to_coarser;
layout(location = 3) in vec2 place;
layout(location = 0) out vec2 in_patch;
layout(location = 1) out vec3 from_eye;
layout(location = 0) uniform mat4 clip_from_eye;
layout(location = 1) uniform vec3 eye_high;
layout(location = 2) uniform vec3 eye_low;
layout(location = 3) uniform float coarser_share;
void main() {
  from_eye = (high - eye_high) + (low - eye_low);
  vec3 up = normalize(eye_high + from_eye);
  gl_Position = clip_from_eye * vec4(from_eye + up * to_coarser * coarser_share, 1.0);
  in_patch = place / 32768.0;
})";

// A place whose height has a part of a void texel is a hole, and through it the underside of what lies beyond
// the horizon must not show: ground without heights is flat.
const char* const kFragment = R"(#version 450
layout(location = 0) in vec2 in_patch;
layout(location = 1) in vec3 from_eye;
layout(location = 1) uniform vec3 eye_high;
layout(location = 5) uniform vec3 radii;
layout(location = 4) uniform vec4 window;  // where the patch lies in its tile, and the tile's layer; < 0: none
layout(binding = 0) uniform usampler2DArray heights;
void main() {
  if (window.w < 0) {
    if (dot((eye_high + from_eye) / (radii * radii), from_eye) > 0) discard;
    return;
  }
  float size = float(textureSize(heights, 0).x);
  vec2 at = (window.xy + clamp(in_patch, 0.0, 1.0) * window.z) * (size - 1.0);
  vec2 part = fract(at), rest = 1.0 - part;
  vec4 weights = vec4(rest.x * part.y, part.x * part.y, part.x * rest.y, rest.x * rest.y);
  uvec4 texels = textureGather(heights, vec3((floor(at) + 1.0) / size, window.w));
  if (dot(weights, vec4(equal(texels, uvec4(65535u)))) > 0.001) discard;
})";

void attach(GLuint program, GLenum kind, const char* text) {
  const GLuint name = glCreateShader(kind);
  glShaderSource(name, 1, &text, nullptr);
  glCompileShader(name);
  glAttachShader(program, name);
}

/// Takes the four attributes that the shader has from vertices of this size.
GLuint vertex_array(GLuint vertices, GLuint indices, GLsizei stride) {
  GLuint name = 0;
  glCreateVertexArrays(1, &name);
  glVertexArrayVertexBuffer(name, 0, vertices, 0, stride);
  glVertexArrayElementBuffer(name, indices);
  for (GLuint i = 0; i < 4; ++i) {
    glEnableVertexArrayAttrib(name, i);
    glVertexArrayAttribBinding(name, i, 0);
  }
  glVertexArrayAttribFormat(name, 0, 3, GL_FLOAT, GL_FALSE, offsetof(cairn::SurfaceVertex, high));
  glVertexArrayAttribFormat(name, 1, 3, GL_FLOAT, GL_FALSE, offsetof(cairn::SurfaceVertex, low));
  glVertexArrayAttribFormat(name, 2, 1, GL_FLOAT, GL_FALSE, offsetof(cairn::SurfaceVertex, to_coarser_m));
  glVertexArrayAttribFormat(name, 3, 2, GL_UNSIGNED_SHORT, GL_FALSE, offsetof(cairn::SurfaceVertex, east));
  return name;
}

GLuint buffer(std::size_t bytes, const void* data) {
  GLuint name = 0;
  glCreateBuffers(1, &name);
  glNamedBufferData(name, static_cast<GLsizeiptr>(bytes), data, GL_STATIC_DRAW);
  return name;
}

/// The heights of a frame's tiles, a layer each.
struct Heights {
  GLuint texture = 0;
  std::map<cairn::TileId, int> layers;
};
Heights heights_of(const std::vector<cairn::SurfaceTextures>& tiles, int size) {
  Heights heights;
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &heights.texture);
  glTextureStorage3D(heights.texture, 1, GL_R16UI, size, size, GLsizei(tiles.size()));
  glTextureParameteri(heights.texture, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTextureParameteri(heights.texture, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 2);
  for (const cairn::SurfaceTextures& tile : tiles) {
    const int layer = int(heights.layers.size());
    heights.layers[tile.id] = layer;
    glTextureSubImage3D(heights.texture, 0, 0, 0, layer, size, size, 1, GL_RED_INTEGER, GL_UNSIGNED_SHORT,
                        tile.heights.texels.data());
  }
  return heights;
}

/// Shows a patch's voids.
void use(const cairn::SurfaceDraw& patch, const cairn::SurfaceFrame& frame, const Heights& heights) {
  const cairn::TileId& tile = frame.tiles[patch.tile]->heights_id;
  const cairn::SurfaceWindow window = cairn::window_in(tile, patch.area);
  const auto layer = heights.layers.find(tile);
  glUniform4f(4, float(window.origin.x), float(window.origin.y), float(window.scale),
              layer == heights.layers.end() ? -1.0f : float(layer->second));
}

void draw(const cairn::SurfaceFrame& frame, const Heights& heights) {
  // One frame only, so that the buffers are as large as it needs.
  const cairn::SurfaceMesh& mesh = frame.mesh;
  const GLuint vertices = buffer(mesh.vertex_end * sizeof(cairn::SurfaceVertex), nullptr);
  const GLuint indices = buffer(mesh.index_end * sizeof(std::uint16_t), nullptr);
  for (const cairn::SurfaceUpload& up : mesh.uploads) {
    glNamedBufferSubData(vertices, GLintptr(up.first_vertex * sizeof up.vertices[0]),
                         GLsizeiptr(up.vertices.size() * sizeof up.vertices[0]), up.vertices.data());
    glNamedBufferSubData(indices, GLintptr(up.first_index * sizeof up.indices[0]),
                         GLsizeiptr(up.indices.size() * sizeof up.indices[0]), up.indices.data());
  }
  glBindTextureUnit(0, heights.texture);
  glBindVertexArray(vertex_array(vertices, indices, sizeof(cairn::SurfaceVertex)));
  for (const cairn::SurfaceDraw& each : mesh.draws) {
    use(each, frame, heights);
    glUniform1f(3, each.coarser_share);
    glDrawElementsBaseVertex(GL_TRIANGLES, GLsizei(each.index_count), GL_UNSIGNED_SHORT,
                             reinterpret_cast<const void*>(each.first_index * sizeof(std::uint16_t)),
                             GLint(each.first_vertex));
  }
  // A single frame glides nowhere: the walls' shares are all 0. The triangles of one patch are in a row.
  const auto& [rims, triangles] = mesh.walls;
  glBindVertexArray(vertex_array(buffer(rims.size() * sizeof rims[0], rims.data()),
                                 buffer(triangles.size() * sizeof triangles[0], triangles.data()),
                                 sizeof(cairn::SurfaceWallVertex)));
  glUniform1f(3, 0);
  for (std::size_t first = 0, last = 0; first < triangles.size(); first = last) {
    const std::uint32_t patch = rims[triangles[first]].shown_as;
    while (last < triangles.size() && rims[triangles[last]].shown_as == patch) last += 3;
    use(mesh.draws[patch], frame, heights);
    glDrawElements(GL_TRIANGLES, GLsizei(last - first), GL_UNSIGNED_INT,
                   reinterpret_cast<const void*>(first * sizeof triangles[0]));
  }
}

int main(int argc, char** argv) {
  if (argc != 4) return std::fprintf(stderr, "usage: draw PACK LON LAT\n"), 2;
  const EGLDisplay display =
      eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION, 4, EGL_CONTEXT_MINOR_VERSION, 5, EGL_NONE};
  eglInitialize(display, nullptr, nullptr);
  eglBindAPI(EGL_OPENGL_API);
  if (!eglMakeCurrent(display, nullptr, nullptr, eglCreateContext(display, nullptr, nullptr, attributes)))
    return std::fprintf(stderr, "no OpenGL 4.5\n"), 1;
  GLuint texture = 0, framebuffer = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &texture);
  glTextureStorage2D(texture, 1, GL_DEPTH_COMPONENT32F, kWidth, kHeight);
  glCreateFramebuffers(1, &framebuffer);
  glNamedFramebufferTexture(framebuffer, GL_DEPTH_ATTACHMENT, texture, 0);
  const auto depth_of = [&](auto picture) {
    const float farthest = 0;
    glClearNamedFramebufferfv(framebuffer, GL_DEPTH, 0, &farthest);
    picture();
    std::vector<float> depth(kWidth * kHeight);
    glGetTextureImage(texture, 0, GL_DEPTH_COMPONENT, GL_FLOAT, GLsizei(depth.size() * sizeof(float)),
                      depth.data());
    return depth;
  };

  auto opened = cairn::PackReader::open(argv[1]);
  if (!opened) return std::fprintf(stderr, "%s\n", opened.error().message.c_str()), 3;
  const auto pack = std::make_shared<const cairn::PackReader>(std::move(*opened));
  cairn::ViewState view{{std::stod(argv[2]), std::stod(argv[3])}, 1500, 90, -10, 0, 60, kWidth, kHeight};

  auto theirs = cairn::GlTerrain::create(pack);
  if (!theirs) return std::fprintf(stderr, "%s\n", theirs.error().message.c_str()), 1;
  cairn::Surface surface(pack->header());
  while (!theirs->update(view, 0).is_settled) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  theirs->cut();
  const cairn::SurfaceFrame& frame = surface.frame(theirs->update(view, 0), {view});
  cairn::GlLook look;
  look.depth_only = true;
  const auto expected = depth_of([&] { theirs->draw(look, {framebuffer, 0, 0, kWidth, kHeight}); });

  const GLuint program = glCreateProgram();
  attach(program, GL_VERTEX_SHADER, kVertex);
  attach(program, GL_FRAGMENT_SHADER, kFragment);
  glLinkProgram(program);
  const Heights heights = heights_of(frame.fresh, pack->header().tile_size);
  const auto drawn = depth_of([&] {
    const glm::dvec3 eye = cairn::camera_frame(view).position;
    const glm::vec3 high(eye), low(eye - glm::dvec3(high));
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glViewport(0, 0, kWidth, kHeight);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glEnable(GL_DEPTH_TEST);
    glEnable(GL_DEPTH_CLAMP);
    glDepthFunc(GL_GREATER);
    glUseProgram(program);
    glUniformMatrix4fv(0, 1, GL_FALSE, glm::value_ptr(glm::mat4(cairn::clip_from_eye(view))));
    glUniform3fv(1, 1, glm::value_ptr(high));
    glUniform3fv(2, 1, glm::value_ptr(low));
    const cairn::Ellipsoid& shape = pack->header().body.shape;
    glUniform3f(5, float(shape.semi_major_m), float(shape.semi_major_m), float(shape.semi_minor_m));
    draw(frame, heights);
  });

  // Along the view, in pixels of that distance; not where a silhouette lies within a pixel.
  double worst = 0;
  std::size_t compared = 0;
  for (int i = kWidth + 1; i < kWidth * (kHeight - 1) - 1; ++i) {
    const auto [least, most] =
        std::minmax({expected[i - kWidth], expected[i - 1], expected[i + 1], expected[i + kWidth]});
    if (most <= 0 && expected[i] <= 0 && drawn[i] > 0) worst = kHeight;  // ground where there is a hole
    if (least <= 0 || most > 1.05f * least) continue;
    worst = std::max(
        worst, std::abs(double(drawn[i]) / expected[i] - 1) * (kHeight / 2 / std::tan(glm::radians(30.0))));
    ++compared;
  }
  std::printf("%zu patches, %llu triangles; largest difference %.4f px of %zu\n", frame.mesh.draws.size(),
              static_cast<unsigned long long>(frame.mesh.triangles), worst, compared);
}
