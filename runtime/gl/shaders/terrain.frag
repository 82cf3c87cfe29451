#version 450 core

struct Patch {
  uint column_table;  // of the first entry
  uint row_table;
  uint cells_log2;
  uint cells_east;
  uint cells_north;
  uint perimeter;     // of the first entry
  uint listed_sides;  // bits: 1 south, 2 north, 4 west, 8 east
  int height_layer;   // < 0: none, all heights are 0
  int height_base;    // quanta
  int height_shift;
  float height_step;    // samples of the source a cell
  int imagery_array;    // 0: none; 1 BC1, 2 BC3, 3 BC7
  vec2 height_origin;   // the source's sample at the patch's south-west corner
  vec2 imagery_origin;  // 0…1 in the source, from its south-west corner
  int imagery_layer;
  float imagery_scale;
  int level;
  int unused;
};
layout(std430, binding = 0) readonly buffer Patches { Patch patches[]; };

layout(binding = 0) uniform sampler2DArray height_texels;
layout(binding = 1) uniform sampler2DArray normal_map;
layout(binding = 2) uniform sampler2DArray bc1;
layout(binding = 3) uniform sampler2DArray bc3;
layout(binding = 4) uniform sampler2DArray bc7;

layout(location = 2) uniform uint tile_cells_log2;
layout(location = 7) uniform float quantum;
layout(location = 3) uniform vec3 eye_geocentric;
layout(location = 4) uniform vec3 to_sun;
layout(location = 5) uniform float eye_height;
layout(location = 6) uniform uint look;  // bits: 1 level colours, 2 fog

layout(location = 0) in vec2 patch_place;
layout(location = 1) in vec3 from_eye;
layout(location = 2) in float height;
layout(location = 3) flat in uint patch_of;

layout(location = 0) out vec4 colour;

const vec3 kInverseRadiiSquared = vec3(1.0 / (6378137.0 * 6378137.0), 1.0 / (6378137.0 * 6378137.0),
                                       1.0 / (6356752.3142 * 6356752.3142));

// Hypsometric tint, linear RGB: water below 0, then lowland green to snow.
vec3 tint(float h) {
  const int kSteps = 9;
  const float at[kSteps] = float[](-8000.0, -200.0, -0.01, 0.01, 300.0, 900.0, 1800.0, 3000.0, 4500.0);
  const vec3 of[kSteps] = vec3[](vec3(0.010, 0.025, 0.090), vec3(0.035, 0.110, 0.240), vec3(0.075, 0.190, 0.330),
                                 vec3(0.105, 0.205, 0.075), vec3(0.200, 0.290, 0.105), vec3(0.400, 0.370, 0.180),
                                 vec3(0.340, 0.230, 0.120), vec3(0.420, 0.360, 0.310), vec3(0.720, 0.735, 0.760));
  vec3 c = of[0];
  for (int i = 1; i < kSteps; ++i) c = mix(c, of[i], smoothstep(at[i - 1], at[i], h));
  return c;
}

vec3 level_colour(int level) {
  float hue = fract(float(level + 9) * 0.381966);
  return 0.25 + 0.5 * clamp(abs(fract(hue + vec3(0.0, 2.0 / 3.0, 1.0 / 3.0)) * 6.0 - 3.0) - 1.0, 0.0, 1.0);
}

// 0…1 in the source of the heights, from its south-west corner.
vec2 place_in_heights(Patch p) {
  float samples = exp2(float(p.cells_log2)) * p.height_step;
  return (p.height_origin + patch_place * samples) / exp2(float(tile_cells_log2));
}

// The tile's own height here: the drawn mesh has fewer vertices than the tile has colours.
float tile_height(Patch p) {
  float cells = exp2(float(tile_cells_log2));
  vec2 place = (place_in_heights(p) * cells + 0.5) / (cells + 1.0);
  float texel = textureLod(height_texels, vec3(place, float(p.height_layer)), 0.0).r * 65535.0;
  return (float(p.height_base) + texel * exp2(float(p.height_shift))) * quantum;
}

const vec3 kNoData = vec3(0.09, 0.10, 0.11);

vec3 surface_colour(Patch p) {
  vec3 plain = (look & 1u) != 0u ? level_colour(p.level) : p.height_layer < 0 ? kNoData : tint(tile_height(p));
  if (p.imagery_array == 0 || (look & 1u) != 0u) return plain;
  vec2 place = p.imagery_origin + patch_place * p.imagery_scale;
  vec3 at = vec3(place.x, 1.0 - place.y, float(p.imagery_layer));  // imagery's rows run from north to south
  vec2 along_x = dFdx(patch_place) * p.imagery_scale * vec2(1, -1);
  vec2 along_y = dFdy(patch_place) * p.imagery_scale * vec2(1, -1);
  vec4 texel = p.imagery_array == 1   ? textureGrad(bc1, at, along_x, along_y)
               : p.imagery_array == 2 ? textureGrad(bc3, at, along_x, along_y)
                                      : textureGrad(bc7, at, along_x, along_y);
  return mix(plain, texel.rgb, texel.a);
}

// Gradients come from the interpolated place: beside a triangle's edge a pixel's neighbours may belong to no
// patch, and what they read of one is undefined.
vec3 normal_east_north_up(Patch p) {
  if (p.height_layer < 0) return vec3(0, 0, 1);
  float scale = exp2(float(p.cells_log2)) * p.height_step / exp2(float(tile_cells_log2));
  vec3 at = vec3(place_in_heights(p), float(p.height_layer));
  vec2 n = textureGrad(normal_map, at, dFdx(patch_place) * scale, dFdy(patch_place) * scale).rg;
  return vec3(n, sqrt(max(0.0, 1.0 - dot(n, n))));
}

// Air between the eye and here, as a share of what hides all: density falls off as exp(-height / 8 km).
float haze(float distance) {
  const float kScale = 8000.0, kPerMetre = 1.0 / 300000.0;
  float a = max(eye_height, 0.0) / kScale, b = max(height, 0.0) / kScale;
  float mean = abs(a - b) < 1e-3 ? exp(-a) : (exp(-min(a, b)) - exp(-max(a, b))) / abs(a - b);
  // Above the air the straight line from eye to ground spends little of its length in it.
  return 1.0 - exp(-kPerMetre * distance * mean);
}

void main() {
  Patch p = patches[patch_of];
  vec3 up = normalize((eye_geocentric + from_eye) * kInverseRadiiSquared);
  vec3 east = normalize(vec3(-up.y, up.x, 1e-9 * up.z));
  vec3 north = cross(up, east);
  vec3 n = normal_east_north_up(p);
  vec3 normal = n.x * east + n.y * north + n.z * up;

  float day = smoothstep(-0.12, 0.15, dot(up, to_sun));
  float sun = max(dot(normal, to_sun), 0.0) * day;
  float sky = 0.5 + 0.5 * dot(normal, up);
  vec3 light = sun * vec3(1.12, 1.06, 0.95) + sky * (0.04 + 0.22 * day) * vec3(0.75, 0.9, 1.15);
  vec3 lit = surface_colour(p) * light;
  if ((look & 2u) != 0u) lit = mix(lit, vec3(0.44, 0.58, 0.78) * (0.03 + 0.97 * day), haze(length(from_eye)));
  colour = vec4(lit, 1.0);
}
