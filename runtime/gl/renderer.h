#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include <glm/vec3.hpp>

#include "cairn/render_list.h"
#include "cairn/status.h"
#include "cairn/view_state.h"
#include "runtime/gl/view_transform.h"
#include "runtime/lod/lod_method.h"
#include "runtime/surface/height_preparation.h"

namespace cairn::gl {

/// How a frame looks.
struct FrameLook {
  glm::dvec3 to_sun{0, 0, 1};            ///< geocentric, unit length
  std::optional<glm::vec3> hole_colour;  ///< linear RGB: drawn where no terrain is, instead of the sky
  bool fog = true;
  bool wireframe = false;
  bool level_colours = false;             ///< a colour for each level of the tiles instead of imagery or tint
  double frame_s = 1.0 / 60;              ///< since the last frame: the exchange of levels follows the clock
  double tolerance_px = 1;                ///< screen error that the mesh may add to the tiles' own; > 0
  const LodMethodInfo* method = nullptr;  ///< draws a method's mesh instead of the renderer's own: on one
                                          ///< thread, tiles exchanged at once, so for comparing pictures
  bool draws = true;                      ///< false: all of a frame's work but the draw calls, to measure it
};

/// What a frame took.
struct FrameCounts {
  std::size_t patches = 0;
  std::size_t triangles = 0;
  std::size_t uploads = 0;      ///< tiles that became textures
  double upload_ms = 0;         ///< CPU time of the thread that this took
  std::uint64_t gpu_bytes = 0;  ///< of textures and buffers
};

/// Draws what the runtime core says, with OpenGL 4.5; the only part of cairn that knows it. Everything is
/// called with one context current, from its thread. docs/viewer.md says how it draws.
class Renderer {
 public:
  /// failed where the context is older than 4.5 or a shader is refused. `tile_size` and `quantum_m` are the
  /// pack's, which has `expected_tiles` at most in a layer; `uploads` outlives the renderer.
  static Result<Renderer> create(int tile_size, double quantum_m, std::size_t expected_tiles,
                                 PreparedHeights& uploads);
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;
  ~Renderer();

  /// Draws a frame into the framebuffer, which needs an sRGB colour and a float depth attachment, over the
  /// view's whole viewport. Tiles are exchanged over several frames, see LodTransition.
  FrameCounts draw(const RenderList& list, const ViewState& view, const FrameLook& look,
                   unsigned framebuffer);

  /// The next frame has nothing to do with the last one, so that nothing of it is on its way to be exchanged.
  void cut();
  /// The height of the ground at a place as the last frame drew it, but for the tolerance; nullopt where
  /// there is none.
  std::optional<double> ground_m(LonLat place) const;

  /// What this context cannot show of what it was given, each once, since the last call.
  std::vector<Error> take_errors();

 private:
  struct State;
  explicit Renderer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cairn::gl
