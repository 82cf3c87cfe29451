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
  uint imagery_array_and_extent;  // 8 bits: 0 none, 1 BC1, 2 BC3, 3 BC7; 12 bits each: texels inside the world, east, north
  vec2 height_origin;   // the source's sample at the patch's south-west corner
  vec2 imagery_origin;  // 0…1 in the source, from its south-west corner
  int imagery_layer;
  float imagery_scale;
  int level;
  float dropped;  // levels less than the source has
  vec4 across[4];  // south, north, west, east: the source's window in the normal map across that side; layer, < 0: none
};
struct PerimeterVertex {
  uint column_row;  // 16 bits each
  float height;
};
layout(std430, binding = 0) readonly buffer Patches { Patch patches[]; };
layout(std430, binding = 1) readonly buffer Perimeter { PerimeterVertex perimeter[]; };
layout(std430, binding = 2) readonly buffer Columns { dvec2 columns[]; };
layout(std430, binding = 3) readonly buffer Rows { dvec4 rows[]; };

layout(binding = 0) uniform sampler2DArray height_texels;

layout(location = 0) uniform dvec3 eye;
layout(location = 1) uniform mat4 clip_from_eye;
layout(location = 2) uniform uint tile_cells_log2;
layout(location = 7) uniform float quantum;
layout(location = 8) uniform vec4 horizon;  // a plane that the Earth's far side lies behind

const uint kOfGrid = 0u, kOfMethod = 1u, kOfWall = 2u;
layout(location = 9) uniform uint vertex_kind;

layout(location = 0) in uint patch_index;
layout(location = 1) in vec3 given_from_eye;
layout(location = 2) in vec3 given_place_and_height;  // of a wall's vertex the place alone
layout(location = 3) in uvec3 wall;  // the patch whose colours it has; as a PerimeterVertex

layout(location = 0) out vec2 patch_place;  // 0…1 from the south-west corner
layout(location = 1) out vec3 from_eye;
layout(location = 2) out float height;
// What the fragments need of the patch, handed on: a pixel beside a triangle's edge has neighbours that belong to
// no patch, and what they would read from a buffer is undefined, but textures' gradients come from them too.
layout(location = 3) flat out vec4 heights_window;  // origin and scale in the source, 0…1; layer
layout(location = 4) flat out vec4 imagery_window;
layout(location = 5) flat out ivec4 patch_facts;  // imagery's array, heights' base and shift, level
layout(location = 6) flat out vec4 extents;  // inside the world: of the patch, 0…1; of the imagery, texels
layout(location = 7) flat out vec4 across[4];

out gl_PerVertex {
  vec4 gl_Position;
  float gl_ClipDistance[2];
};

const uint kVoidTexel = 65535u;

// The 16 bits as stored; the texture is a normalised one so that terrain.frag can filter it.
uint texel(Patch p, ivec2 at) {
  ivec3 place = ivec3(min(at, ivec2(1 << tile_cells_log2)), p.height_layer);
  return uint(round(texelFetch(height_texels, place, 0).r * 65535.0));
}

// Rounded as gl::height_at() rounds it.
float metres(Patch p, uint texel) {
  precise float height = float(p.height_base + (int(texel) << p.height_shift)) * quantum;
  return height;
}

// The height at a place of the source with every 2^rows-th row and column kept, on the triangles between the samples, as
// gl::height_at(). NaN for a void would not survive every driver: the flag is apart.
float thinned_height(Patch p, vec2 place, int rows, out bool is_void) {
  vec2 at = ldexp(place, ivec2(-rows));
  ivec2 low = ivec2(floor(at));
  vec2 part = at - vec2(low);
  uint sw = texel(p, low << rows);
  if (part == vec2(0)) {
    is_void = sw == kVoidTexel;
    return metres(p, sw);
  }
  bool east = part.x > part.y;
  uint other = texel(p, (low + (east ? ivec2(1, 0) : ivec2(0, 1))) << rows), ne = texel(p, (low + 1) << rows);
  float far = max(part.x, part.y), near = min(part.x, part.y);
  is_void = max(sw, max(far > near ? other : sw, near > 0.0 ? ne : sw)) == kVoidTexel;
  return metres(p, sw) + (metres(p, other) - metres(p, sw)) * far + (metres(p, ne) - metres(p, other)) * near;
}

// Where a level's sample is void, the next finer level stands in. REQUIRES: the finest is not void there.
float known_height(Patch p, vec2 place, int rows) {
  bool is_void;
  float height = thinned_height(p, place, rows, is_void);
  while (is_void && rows > 0) height = thinned_height(p, place, --rows, is_void);
  return height;
}

// With as much detail as is shown, as gl::height_at() of a ShownSurface.
float sampled_height(Patch p, uvec2 vertex, out bool is_void) {
  is_void = false;
  if (p.height_layer < 0) return 0.0;
  vec2 place = p.height_origin + vec2(vertex) * p.height_step;
  float finest = thinned_height(p, place, 0, is_void);
  if (p.dropped == 0.0 || is_void) return finest;
  int rows = int(ceil(p.dropped));
  float coarse = known_height(p, place, rows);
  return coarse + (known_height(p, place, rows - 1) - coarse) * (float(rows) - p.dropped);
}

// The entry of a vertex on a listed side, -1 where it is on none.
int listed_entry(uvec2 v, Patch p, uint cells) {
  bool on_side[4] = bool[](v.y == 0u, v.y == p.cells_north, v.x == 0u, v.x == p.cells_east);
  uint entry = p.perimeter;
  for (uint side = 0u; side < 4u; ++side) {
    if ((p.listed_sides >> side & 1u) == 0u) continue;
    if (on_side[side]) return int(entry + (side < 2u ? v.x : v.y));
    entry += cells + 1u;
  }
  return -1;
}

// Doubles until the eye is subtracted: a float at the Earth's radius has steps of half a metre. The same
// entries and the same operations give the same bits for a vertex of any patch.
vec3 position_from_eye(Patch p, uvec2 vertex) {
  uvec2 entry = vertex << (tile_cells_log2 - p.cells_log2);
  dvec2 column = columns[p.column_table + entry.x];
  dvec4 row = rows[p.row_table + entry.y];
  double hd = double(height);
  precise double from_axis = row.x + hd * row.y;
  precise dvec3 relative = dvec3(from_axis * column.x - eye.x, from_axis * column.y - eye.y,
                                 (row.z + hd * row.w) - eye.z);
  return vec3(relative);
}

uvec2 column_and_row(uint both) {
  return uvec2(both & 65535u, both >> 16);
}

// Sets the place, the height and the position of a grid's vertex; whether it is void.
bool take_from_grid(Patch p) {
  uint cells = 1u << p.cells_log2;
  uvec2 v = uvec2(uint(gl_VertexID) % (cells + 1u), uint(gl_VertexID) / (cells + 1u));
  v = min(v, uvec2(p.cells_east, p.cells_north));
  bool is_void;
  int entry_of_side = listed_entry(v, p, cells);
  if (entry_of_side >= 0) {
    PerimeterVertex on_side = perimeter[entry_of_side];
    v = column_and_row(on_side.column_row);
    height = on_side.height;
    is_void = isnan(height);
  } else {
    height = sampled_height(p, v, is_void);
  }
  if (is_void) height = 0.0;
  patch_place = vec2(v) / float(cells);
  from_eye = position_from_eye(p, v);
  return is_void;
}

// The same of a wall's, which has a place in the patch that it is shown as, and stands on a vertex of the other.
void take_from_wall(Patch p) {
  patch_place = given_place_and_height.xy;
  height = uintBitsToFloat(wall.z);
  from_eye = position_from_eye(p, column_and_row(wall.y));
}

void main() {
  Patch p = patches[patch_index];
  bool is_void = false;
  if (vertex_kind == kOfWall) {
    take_from_wall(p);
    p = patches[wall.x];
  } else if (vertex_kind == kOfMethod) {
    from_eye = given_from_eye;
    patch_place = given_place_and_height.xy;
    height = given_place_and_height.z;
  } else {
    is_void = take_from_grid(p);
  }
  precise vec4 clip = clip_from_eye * vec4(from_eye, 1.0);
  gl_Position = clip;
  gl_ClipDistance[0] = is_void ? -1e9 : 1.0;
  gl_ClipDistance[1] = dot(horizon.xyz, from_eye) + horizon.w;
  float cells = float(1u << p.cells_log2), tile_cells = exp2(float(tile_cells_log2));
  extents = vec4(vec2(p.cells_east, p.cells_north) / cells, vec2(p.imagery_array_and_extent >> 8 & 4095u, p.imagery_array_and_extent >> 20));
  heights_window = vec4(p.height_origin / tile_cells, cells * p.height_step / tile_cells, float(p.height_layer));
  imagery_window = vec4(p.imagery_origin, p.imagery_scale, float(p.imagery_layer));
  across = p.across;
  patch_facts = ivec4(p.imagery_array_and_extent & 255u, p.height_base, p.height_shift, p.level);
}
