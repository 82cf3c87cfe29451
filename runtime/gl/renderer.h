#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "cairn/gl_terrain.h"
#include "cairn/status.h"
#include "cairn/surface.h"
#include "runtime/light/sun_shadows.h"

namespace cairn::gl {

/// Draws surfaces with OpenGL 4.5; the only part of cairn that knows it. Everything is called with one
/// context current, from its thread. What of the host's state it depends on or changes is kept and given
/// back. docs/viewer.md says how it draws.
class Renderer {
 public:
  /// failed where the context is older than 4.5 or a shader is refused. The pack has `expected_tiles` at most
  /// in a layer.
  static Result<Renderer> create(int tile_size, double quantum_m, std::size_t expected_tiles);
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;
  ~Renderer();

  /// Uploads what is new in a frame: every frame once, before it is drawn. Returns the number of tiles.
  std::size_t take(const SurfaceFrame& frame);

  /// A view, as the shaders see it.
  struct Camera {
    ViewState view;
    glm::dmat4 clip_from_eye{1};
    double lowest_m = 0;  ///< no ground is lower
  };
  /// Draws `mesh`, the frame's own or another of its tiles, over what the target has. `calls` false: all of
  /// a frame's work but the draw calls, to measure it.
  GlCounts draw(const SurfaceFrame& frame, const SurfaceMesh& mesh, const Camera& camera, const GlLook& look,
                const GlTarget& target, bool calls = true);

  /// Takes the shadows that are done, and asks for those that are due of the tiles that a mesh shows. Returns
  /// how many of them are not there yet: these tiles show none, or that of a sun that has moved on.
  std::size_t update_shadows(SunShadows& shadows, const SurfaceFrame& frame, const SurfaceMesh& mesh,
                             const glm::dvec3& to_sun);

  /// What this context cannot show of what it was given, each once, since the last call.
  std::vector<Error> take_errors();

 private:
  struct State;
  explicit Renderer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Clears a target for a picture: to a colour, linear RGB, and to the farthest depth.
void clear(const GlTarget& target, const glm::vec3& colour);

}  // namespace cairn::gl
