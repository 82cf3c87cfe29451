#version 450 core

struct Patch {
  int height_layer;  // < 0: none, all heights are 0
  int height_base;   // quanta
  int height_shift;
  uint imagery_array_and_extent;  // 8 bits: 0 none, 1 BC1, 2 BC3, 3 BC7; 12 bits each: texels inside the world, east, north
  vec2 height_origin;   // 0…1 in the source, from its south-west corner
  float height_scale;
  float coarser_share;  // of the vertices' way to the coarser level's height
  vec2 imagery_origin;  // 0…1 in the source, from its south-west corner
  int imagery_layer;
  float imagery_scale;
  int level;
  uint first_segment;  // of those that are draped on it
  uint segment_count;
  vec4 across[4];  // south, north, west, east: the source's window in the normal map across that side; layer, < 0: none
};
layout(std430, binding = 0) readonly buffer Patches { Patch patches[]; };

layout(location = 0) uniform vec3 eye_high;
layout(location = 9) uniform vec3 eye_low;
layout(location = 11) uniform vec3 radii;  // of the ellipsoid
layout(location = 1) uniform mat4 clip_from_eye;
layout(location = 8) uniform vec4 horizon;  // a plane that the body's far side lies behind

layout(location = 0) in vec3 position_high;
layout(location = 1) in vec3 position_low;
layout(location = 2) in vec2 heights;      // metres; what the coarser level's is above it
layout(location = 3) in vec2 place;        // of 32768
layout(location = 4) in uvec2 patch_pair;  // which it glides with, and which it shows

layout(location = 0) out vec2 patch_place;  // 0…1 from the south-west corner
layout(location = 1) out vec3 from_eye;
layout(location = 2) out float height;
// What the fragments need of the patch, handed on: a pixel beside a triangle's edge has neighbours that belong to
// no patch, and what they would read from a buffer is undefined, but textures' gradients come from them too.
layout(location = 3) flat out vec4 heights_window;  // origin and scale in the source, 0…1; layer
layout(location = 4) flat out vec4 imagery_window;
layout(location = 5) flat out ivec4 patch_facts;  // imagery's array, heights' base and shift, level
layout(location = 6) flat out vec2 extents;  // of the imagery inside the world, texels
layout(location = 7) flat out vec4 across[4];
layout(location = 11) flat out uvec2 draped;  // the first segment, and how many

out gl_PerVertex {
  vec4 gl_Position;
  float gl_ClipDistance[1];
};

// Single precision alone has steps of half a metre at the Earth's radius. Equal vertices give equal bits in any patch.
vec3 position_from_eye(float above) {
  precise vec3 from = (position_high - eye_high) + (position_low - eye_low);
  if (above == 0.0) return from;
  precise vec3 up = normalize((eye_high + from) / (radii * radii));
  precise vec3 glided = from + up * above;
  return glided;
}

void main() {
  float above = heights.y * patches[patch_pair.x].coarser_share;
  Patch p = patches[patch_pair.y];
  from_eye = position_from_eye(above);
  height = heights.x + above;
  patch_place = place / 32768.0;
  precise vec4 clip = clip_from_eye * vec4(from_eye, 1.0);
  gl_Position = clip;
  gl_ClipDistance[0] = dot(horizon.xyz, from_eye) + horizon.w;
  extents = vec2(p.imagery_array_and_extent >> 8 & 4095u, p.imagery_array_and_extent >> 20);
  heights_window = vec4(p.height_origin, p.height_scale, float(p.height_layer));
  imagery_window = vec4(p.imagery_origin, p.imagery_scale, float(p.imagery_layer));
  across = p.across;
  draped = uvec2(p.first_segment, p.segment_count);
  patch_facts = ivec4(p.imagery_array_and_extent & 255u, p.height_base, p.height_shift, p.level);
}
