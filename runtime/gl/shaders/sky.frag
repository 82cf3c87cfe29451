#version 450 core

layout(location = 3) uniform vec3 eye_geocentric;
layout(location = 4) uniform vec3 to_sun;
layout(location = 5) uniform float eye_height;
layout(location = 6) uniform uint look;  // bits: 2 fog, 4 the Earth, which has air, 8 dithering
layout(location = 11) uniform vec3 ellipsoid_radii;
layout(location = 10) uniform float lowest;  // metres: no ground of the pack is lower; 0 or below

layout(location = 0) in vec3 ray;
layout(location = 0) out vec4 colour;

#include "dither.glsl"

// Light scattered once, by air whose density falls off as exp(-height / 8 km) around a sphere. Rayleigh's
// coefficients are those of sea-level air at 680, 550 and 440 nm.
const float kTop = 100000.0, kScale = 8000.0;
const vec3 kScatter = vec3(5.8e-6, 13.5e-6, 33.1e-6);
const int kSteps = 16;

const vec3 kBare = vec3(0.09, 0.10, 0.11);

vec3 radii() {
  return ellipsoid_radii + lowest;
}

// How far the lowest ground may be along the ray, < 0 where the ray misses it; what lies above it is drawn as terrain, so
// that this is seen through holes only, and never above the horizon of a sea floor.
float distance_to_ground(vec3 d) {
  vec3 e = eye_geocentric / radii(), s = d / radii();
  float a = dot(s, s), b = dot(e, s), c = dot(e, e) - 1.0;
  if (b >= 0.0) return -1.0;
  if (c <= 0.0) return 0.0;
  float root = b * b - a * c;
  return root < 0.0 ? -1.0 : c / (-b + sqrt(root));
}

// As terrain.frag draws areas for which the pack has nothing.
vec3 bare_ground(vec3 d, float distance) {
  vec3 up = normalize((eye_geocentric + d * distance) / (radii() * radii()));
  if ((look & 4u) == 0u) return kBare * (1.4 * max(dot(up, to_sun), 0.0) + 0.015);
  float day = smoothstep(-0.12, 0.15, dot(up, to_sun));
  vec3 light = max(dot(up, to_sun), 0.0) * day * vec3(1.12, 1.06, 0.95) + (0.04 + 0.22 * day) * vec3(0.75, 0.9, 1.15);
  float a = max(eye_height, 0.0) / kScale;
  float mean = a < 1e-3 ? 1.0 : (1.0 - exp(-a)) / a;
  float haze = (look & 2u) != 0u ? 1.0 - exp(-distance / 300000.0 * mean) : 0.0;
  return mix(kBare * light, vec3(0.44, 0.58, 0.78) * (0.03 + 0.97 * day), haze);
}

vec3 sky(vec3 d) {
  float cosine = dot(d, to_sun);
  vec3 sun = smoothstep(0.99996, 0.99998, cosine) * vec3(8.0, 7.4, 6.5);
  if ((look & 4u) == 0u) {
    return 1.0 - exp(-sun);
  }
  // Heights above the ellipsoid, not the sphere, decide how much air there is.
  float mean_radius = (2.0 * ellipsoid_radii.x + ellipsoid_radii.z) / 3.0;
  vec3 e = eye_geocentric / ellipsoid_radii * mean_radius;
  float middle = -dot(e, d);
  float nearest2 = dot(e, e) - middle * middle;
  float outer2 = (mean_radius + kTop) * (mean_radius + kTop);
  vec3 sum = vec3(0);
  if (nearest2 < outer2) {
    float half_chord = sqrt(outer2 - nearest2);
    float first = max(middle - half_chord, 0.0), last = middle + half_chord;
    if (last > first) {
      float depth = 0.0;
      float step_length = (last - first) / float(kSteps);
      for (int i = 0; i < kSteps; ++i) {
        vec3 at = e + d * (first + (float(i) + 0.5) * step_length);
        float r = length(at);
        float density = exp(-max(r - mean_radius, 0.0) / kScale) * step_length;
        float day = smoothstep(-0.15, 0.2, dot(at / r, to_sun));
        sum += density * day * exp(-kScatter * (depth + 0.5 * density));
        depth += density;
      }
    }
  }
  vec3 light = 6.0 * kScatter * sum * (3.0 / (16.0 * 3.14159265)) * (1.0 + cosine * cosine) * 3.0;
  return 1.0 - exp(-(light + sun));
}

void main() {
  vec3 d = normalize(ray);
  float ground = distance_to_ground(d);
  vec3 seen = ground >= 0.0 ? bare_ground(d, ground) : sky(d);
  colour = vec4((look & 8u) != 0u ? dithered(seen) : seen, 1.0);
}
