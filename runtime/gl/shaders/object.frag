#version 450 core

layout(binding = 0) uniform sampler2DArray picture;

layout(location = 3) uniform vec3 eye_geocentric;
layout(location = 4) uniform vec3 to_sun;
layout(location = 5) uniform float eye_height;
layout(location = 6) uniform uint look;  // bits: 2 fog, 4 the Earth, 8 dithering
layout(location = 11) uniform vec3 radii;  // of the ellipsoid
layout(location = 12) uniform uint views;

layout(location = 0) in vec2 place;
layout(location = 1) in vec3 from_eye;
layout(location = 2) in vec3 facing;
layout(location = 3) flat in vec3 up;
layout(location = 4) flat in vec2 shown;
layout(location = 5) flat in vec4 cell;

layout(location = 0) out vec4 colour;

#include "develop.glsl"
#include "light.glsl"

void main() {
  float pattern = screen_noise();
  if (pattern < shown.x || pattern >= shown.y) discard;
  vec2 half_texel = 0.5 / vec2(textureSize(picture, 0).xy);
  vec4 texel = texture(picture, vec3(clamp(place, cell.xy + half_texel, cell.zw - half_texel), 0.0));
  if (texel.a < 0.5) discard;
  vec3 normal = normalize(facing);
  if (views == 0u && !gl_FrontFacing) normal = -normal;
  vec3 lit = seen_colour(texel.rgb, normal, up, eye_height + dot(from_eye, up), from_eye, 1.0);
  colour = developed(lit);
}
