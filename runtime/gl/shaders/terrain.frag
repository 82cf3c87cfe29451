#version 450 core

layout(binding = 0) uniform sampler2DArray height_texels;
layout(binding = 1) uniform sampler2DArray normal_map;
layout(binding = 2) uniform sampler2DArray bc1;
layout(binding = 3) uniform sampler2DArray bc3;
layout(binding = 4) uniform sampler2DArray bc7;
layout(binding = 5) uniform sampler2DArray shadow_texels;  // how far ground rises above the sun, 1: 2 degrees

layout(location = 2) uniform uint tile_cells_log2;
layout(location = 7) uniform float quantum;
layout(location = 3) uniform vec3 eye_geocentric;
layout(location = 4) uniform vec3 to_sun;
layout(location = 5) uniform float eye_height;
layout(location = 6) uniform uint look;  // bits: 1 level colours, 2 fog, 4 the Earth, 8 dithering, 16 shadows, 32 water, 64 slope colours
layout(location = 11) uniform vec3 radii;  // of the ellipsoid
layout(location = 12) uniform float sea_level;    // metres
layout(location = 13) uniform float contour_gap;  // metres between contour lines, 0: none
layout(location = 15) uniform float imagery_share;
layout(location = 16) uniform int tint_count;
layout(location = 17) uniform vec4 tint_stops[16];  // linear RGB, and the height in metres

struct Segment {
  vec4 ends;              // in the patch: x, y, x, y
  vec4 colour_and_width;  // linear RGB; pixels
};
layout(std430, binding = 1) readonly buffer Segments { Segment segments[]; };

layout(location = 0) in vec2 patch_place;
layout(location = 1) in vec3 from_eye;
layout(location = 2) in float height;
layout(location = 3) flat in vec4 heights_window;
layout(location = 4) flat in vec4 imagery_window;
layout(location = 5) flat in ivec4 patch_facts;
layout(location = 6) flat in vec2 extents;
layout(location = 7) flat in vec4 across[4];  // south, north, west, east
layout(location = 11) flat in uvec2 draped;  // the first segment, and how many

layout(location = 0) out vec4 colour;

#include "develop.glsl"
#include "light.glsl"
#include "water.glsl"

// Hypsometric tint, linear RGB.
vec3 tint(float h) {
  vec3 c = tint_stops[0].rgb;
  for (int i = 1; i < tint_count; ++i) {
    c = mix(c, tint_stops[i].rgb, smoothstep(tint_stops[i - 1].w, tint_stops[i].w, h));
  }
  return c;
}

vec3 level_colour(int level) {
  float hue = fract(float(level + 9) * 0.381966);
  return 0.25 + 0.5 * clamp(abs(fract(hue + vec3(0.0, 2.0 / 3.0, 1.0 / 3.0)) * 6.0 - 3.0) - 1.0, 0.0, 1.0);
}

// Interpolated in a thin triangle, a place may round to one outside the patch.
vec2 within_patch() {
  return clamp(patch_place, 0.0, 1.0);
}

bool has_heights() {
  return heights_window.w >= 0.0;
}

// The tile's own height here: the drawn mesh has fewer vertices than the tile has colours. A void beside it is a hole.
float tile_height() {
  float samples = exp2(float(tile_cells_log2)) + 1.0;
  vec2 place = (heights_window.xy + within_patch() * heights_window.z) * (samples - 1.0);
  vec4 texels = round(textureGather(height_texels, vec3((floor(place) + 1.0) / samples, heights_window.w)) * 65535.0);
  vec2 part = fract(place), rest = 1.0 - part;
  vec4 weights = vec4(rest.x * part.y, part.x * part.y, part.x * rest.y, rest.x * rest.y);
  weights *= vec4(lessThan(texels, vec4(65535.0)));
  // At the ends of the world a rounded sum may be a hair beyond, where all is void.
  float known = dot(weights, vec4(1.0));
  if (known < 0.999) discard;
  float texel = dot(weights, texels) / known;
  return (float(patch_facts.y) + texel * exp2(float(patch_facts.z))) * quantum;
}

const vec3 kNoData = vec3(0.09, 0.10, 0.11);

// A tile that overhangs the world in the east has void texels there. The filter must not reach them: the place stays half a
// texel of the coarser of the two mips west of 180°.
vec2 imagery_place(vec2 along_x, vec2 along_y) {
  vec2 place = imagery_window.xy + within_patch() * imagery_window.z;
  float texels = exp2(float(tile_cells_log2));
  float footprint = max(length(along_x), length(along_y)) * texels;
  float width = exp2(clamp(ceil(log2(max(footprint, 1.0))), 0.0, float(tile_cells_log2)));
  // Not at the pole: there the mip follows the narrow meridians, and half its texel is far along them.
  float last = (max(floor(extents.x / width), 1.0) - 0.5) * width / texels;
  if (extents.x < texels) place.x = min(place.x, last);
  return place;
}

vec4 imagery_at(vec3 at, vec2 along_x, vec2 along_y) {
  return patch_facts.x == 1   ? textureGrad(bc1, at, along_x, along_y)
         : patch_facts.x == 2 ? textureGrad(bc3, at, along_x, along_y)
                              : textureGrad(bc7, at, along_x, along_y);
}

// Towards a pole the meridians come together, and a pixel is as wide as many texels: a mip as coarse as that would blur
// along the meridians, too. So the mean of several places along the parallel is shown, each filtered for its share of the
// width. They stay between the tile's sides, where neighbours agree.
const float kMostTaps = 8.0;
vec4 imagery_texel(vec3 up) {
  vec2 along_x = dFdx(patch_place) * imagery_window.z * vec2(1, -1);
  vec2 along_y = dFdy(patch_place) * imagery_window.z * vec2(1, -1);
  float taps = clamp(ceil(0.5 / max(length(up.xy), 1e-6)), 1.0, kMostTaps);
  float width = max(abs(along_x.x), abs(along_y.x));
  along_x.x /= taps;
  along_y.x /= taps;
  vec2 place = imagery_place(along_x, along_y);
  float inside = min(place.x, extents.x / exp2(float(tile_cells_log2)) - place.x);
  float spread = clamp(inside, 0.0, 0.5 * width * (taps - 1.0) / taps);
  vec4 sum = vec4(0.0);
  for (float tap = 0.0; tap < taps; ++tap) {
    float aside = taps > 1.0 ? spread * (2.0 * tap / (taps - 1.0) - 1.0) : 0.0;
    // Imagery's rows run from north to south.
    sum += imagery_at(vec3(place.x + aside, 1.0 - place.y, imagery_window.w), along_x, along_y);
  }
  return sum / taps;
}

vec3 surface_colour(vec3 up) {
  vec3 plain = has_heights() ? tint(tile_height()) : kNoData;
  if ((look & 1u) != 0u) return level_colour(patch_facts.w);
  if (patch_facts.x == 0 || imagery_share == 0.0) return plain;
  vec4 texel = imagery_texel(up);
  return mix(plain, texel.rgb, texel.a * imagery_share);
}

// The east and north parts of a normal map's normal; the window is where the place's map lies in it.
vec2 mapped_normal(vec4 window, vec2 place) {
  float scale = window.z * heights_window.z;
  return textureGrad(normal_map, vec3(window.xy + place * window.z, window.w), dFdx(patch_place) * scale,
                     dFdy(patch_place) * scale).rg;
}

// Beyond the middle of a map's outermost texels the filter has none to mix them with: those across the side are mixed in,
// half at the side, as the filter would, and all of a coarser one's, whose own side stays as it is.
vec3 normal_east_north_up() {
  if (!has_heights()) return vec3(0, 0, 1);
  vec2 place = heights_window.xy + within_patch() * heights_window.z;
  vec2 n = mapped_normal(vec4(0, 0, 1, heights_window.w), place);
  vec4 texels = vec4(place.y, 1.0 - place.y, place.x, 1.0 - place.x) * exp2(float(tile_cells_log2));
  for (int side = 0; side < 4; ++side) {
    if (across[side].w < 0.0) continue;
    float share = (across[side].z < 1.0 ? 1.0 : 0.5) - texels[side];
    if (share > 0.0) n = mix(n, mapped_normal(across[side], place), share);
  }
  return vec3(n, sqrt(max(0.0, 1.0 - dot(n, n))));
}

// The share of the sun's disc, 0.53 degrees wide, that no ground hides.
float sun_share() {
  if ((look & 16u) == 0u || !has_heights()) return 1.0;
  float samples = exp2(float(tile_cells_log2)) + 1.0;
  vec2 place = (heights_window.xy + within_patch() * heights_window.z) * (samples - 1.0);
  float rise = 2.0 * textureLod(shadow_texels, vec3((place + 0.5) / samples, heights_window.w), 0.0).r;
  return smoothstep(-0.267, 0.267, -rise);
}

// Single precision gives a height no better than this, metres.
const float kHeightStep = 0.02;

// Ground at a height below that of the sea, seen through water. A source's sea at this very height says nothing of its depth.
vec3 under_water(vec3 ground, float above, float sun_seen) {
  vec3 d = normalize(from_eye);
  float surface = distance_to_sea(d), floor_distance = length(from_eye);
  float through = surface >= 0.0 && above < sea_level - kHeightStep ? max(floor_distance - surface, 0.0) : -1.0;
  return water_colour(d, surface >= 0.0 ? min(surface, floor_distance) : floor_distance, ground, through, sun_seen);
}

// Avalanche classes: below 25 degrees nothing, then 30, 35, 40 and 45.
vec3 slope_colour(float cosine, vec3 ground) {
  float degrees_ = degrees(acos(clamp(cosine, -1.0, 1.0)));
  vec3 of = degrees_ < 25.0   ? ground
            : degrees_ < 30.0 ? vec3(0.95, 0.85, 0.20)
            : degrees_ < 35.0 ? vec3(0.90, 0.50, 0.10)
            : degrees_ < 40.0 ? vec3(0.80, 0.10, 0.08)
            : degrees_ < 45.0 ? vec3(0.55, 0.08, 0.40)
                              : vec3(0.20, 0.08, 0.35);
  return mix(ground, of, degrees_ < 25.0 ? 0.0 : 0.65);
}

// Lines of equal height, a pixel and a half wide, each fifth twice as strong; they fade where they would touch.
vec3 with_contours(vec3 ground, float above) {
  float lines = above / contour_gap;
  float per_pixel = max(fwidth(height) / contour_gap, 1e-6);
  float nearest = round(lines);
  bool is_fifth = mod(nearest, 5.0) == 0.0;
  float wide = is_fifth ? 1.1 : 0.7;
  float line = 1.0 - smoothstep(wide - 0.5, wide + 0.5, abs(lines - nearest) / per_pixel);
  float room = 1.0 - smoothstep(0.12, 0.35, is_fifth ? per_pixel / 5.0 : per_pixel);
  return mix(ground, vec3(0.10, 0.05, 0.02), line * room * (is_fifth ? 0.9 : 0.6));
}

// Lines and points that are draped on the ground. How far a pixel is from one is taken from how the place changes from pixel
// to pixel, so that it follows the drawn ground exactly; where ground is upright, as walls are, there is no such change.
vec3 with_lines(vec3 seen) {
  mat2 place_from_pixel = mat2(dFdx(patch_place), dFdy(patch_place));
  float area = determinant(place_from_pixel);
  if (abs(area) < 1e-20) return seen;
  mat2 pixel_from_place = inverse(place_from_pixel);
  for (uint i = draped.x; i < draped.x + draped.y; ++i) {
    vec2 from = pixel_from_place * (segments[i].ends.xy - patch_place);
    vec2 along = pixel_from_place * (segments[i].ends.zw - patch_place) - from;
    float share = clamp(-dot(from, along) / max(dot(along, along), 1e-12), 0.0, 1.0);
    float beyond = length(from + share * along) - 0.5 * segments[i].colour_and_width.w;
    seen = mix(seen, segments[i].colour_and_width.rgb, 1.0 - smoothstep(-0.5, 0.5, beyond));
  }
  return seen;
}

void main() {
  vec3 up = normalize((eye_geocentric + from_eye) / (radii * radii));
  // Ground without heights is flat. Its underside shows through voids only, from beyond the horizon.
  if (!has_heights() && dot(up, from_eye) > 0.0) discard;
  vec3 east = normalize(vec3(-up.y, up.x, 1e-9 * up.z));
  vec3 north = cross(up, east);
  vec3 n = normal_east_north_up();
  vec3 normal = n.x * east + n.y * north + n.z * up;

  float above = has_heights() ? tile_height() : 0.0;
  float sun_seen = sun_share();
  bool is_sea = (look & 32u) != 0u && has_heights() && above < sea_level + kHeightStep;
  vec3 ground = surface_colour(up);
  if ((look & 64u) != 0u && has_heights() && !is_sea) ground = slope_colour(n.z, ground);
  if (contour_gap > 0.0 && has_heights()) ground = with_contours(ground, above);
  vec3 lit;
  if (is_sea && eye_height > sea_level) {
    // The air is in front of the water, not in it.
    float day = smoothstep(-0.12, 0.15, dot(up, to_sun));
    lit = under_water(ground * (0.2 + 0.8 * max(dot(normal, to_sun), 0.0)) * day, above, sun_seen);
  } else {
    lit = seen_colour(ground, normal, up, above, from_eye, sun_seen);
  }
  colour = developed(draped.y > 0u ? with_lines(lit) : lit);
}
