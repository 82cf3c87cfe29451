#version 450 core

layout(location = 3) uniform vec3 eye_geocentric;
layout(location = 4) uniform vec3 to_sun;
layout(location = 5) uniform float eye_height;
layout(location = 6) uniform uint look;  // bits: 2 fog, 4 the Earth, which has air, 8 dithering, 32 water
layout(location = 11) uniform vec3 radii;  // of the ellipsoid
layout(location = 12) uniform float sea_level;  // metres
layout(location = 10) uniform float lowest;  // metres: no ground of the pack is lower; 0 or below

layout(location = 0) in vec3 ray;
layout(location = 0) out vec4 colour;

#include "develop.glsl"
#include "light.glsl"
#include "water.glsl"

const vec3 kBare = vec3(0.09, 0.10, 0.11);

// How far the lowest ground may be along the ray, < 0 where the ray misses it; what lies above it is drawn as terrain, so
// that this is seen through holes only, and never above the horizon of a sea floor.
float distance_to_ground(vec3 d) {
  vec3 lowest_radii = radii + lowest;
  vec3 e = eye_geocentric / lowest_radii, s = d / lowest_radii;
  float a = dot(s, s), b = dot(e, s), c = dot(e, e) - 1.0;
  if (b >= 0.0) return -1.0;
  if (c <= 0.0) return 0.0;
  float root = b * b - a * c;
  return root < 0.0 ? -1.0 : c / (-b + sqrt(root));
}

// As terrain.frag draws areas for which the pack has nothing.
vec3 bare_ground(vec3 d, float distance) {
  vec3 up = normalize((eye_geocentric + d * distance) / (radii * radii));
  return seen_colour(kBare, up, up, 0.0, d * distance, 1.0);
}

vec3 sky(vec3 d) {
  float disc = smoothstep(0.9999875, 0.9999905, dot(d, to_sun));  // the sun's radius is 0.267 degrees
  if ((look & 4u) == 0u) return exposed(disc * vec3(8.0, 7.4, 6.5));
  Air air = air_along(d, 1e9, 16);
  return exposed(air.scattered + disc * 60.0 * air.passes);
}

void main() {
  vec3 d = normalize(ray);
  float ground = distance_to_ground(d);
  float sea = (look & 32u) != 0u && eye_height > sea_level ? distance_to_sea(d) : -1.0;
  vec3 seen = sea >= 0.0      ? water_colour(d, sea, vec3(0.0), -1.0, 1.0)
              : ground >= 0.0 ? bare_ground(d, ground)
                              : sky(d);
  colour = developed(seen);
}
