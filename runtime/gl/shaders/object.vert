#version 450 core

layout(location = 1) uniform mat4 clip_from_eye;
layout(location = 3) uniform vec3 eye_geocentric;
layout(location = 11) uniform vec3 radii;  // of the ellipsoid
layout(location = 12) uniform uint views;  // of the billboard; 0: the triangles are drawn
layout(location = 13) uniform vec3 extent;  // of a view: its half width, its bottom and its top, metres

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 texture_place;
layout(location = 3) in vec4 foot_and_scale;     // from the eye
layout(location = 4) in vec4 heading_and_shown;  // sine and cosine; which values of the pattern are drawn

layout(location = 0) out vec2 place;
layout(location = 1) out vec3 from_eye;
layout(location = 2) out vec3 facing;
layout(location = 3) flat out vec3 up;
layout(location = 4) flat out vec2 shown;
layout(location = 5) flat out vec4 cell;  // of the texture: the corners that a place stays between

const float kTurn = 6.28318531;

void main() {
  vec3 foot = foot_and_scale.xyz;
  up = normalize((eye_geocentric + foot) / (radii * radii));
  vec3 east = normalize(vec3(-up.y, up.x, 1e-9 * up.z));
  vec3 north = cross(up, east);
  vec3 own_north = heading_and_shown.x * east + heading_and_shown.y * north;
  vec3 own_east = heading_and_shown.y * east - heading_and_shown.x * north;
  shown = heading_and_shown.zw;
  vec3 from_foot;
  if (views == 0u) {
    from_foot = own_east * position.x + own_north * position.y + up * position.z;
    facing = own_east * normal.x + own_north * normal.y + up * normal.z;
    place = texture_place;
    cell = vec4(-1e9, -1e9, 1e9, 1e9);
  } else {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    vec3 level = -foot - up * dot(-foot, up);
    vec3 to_eye = length(level) > 1e-6 * length(foot) ? normalize(level) : north;
    vec3 right = cross(up, to_eye);
    // A picture that turns to the eye leans back as the eye rises; the views of a model stand upright.
    vec3 upright = views == 1u ? normalize(cross(-normalize(foot), right)) : up;
    from_foot = right * (2.0 * corner.x - 1.0) * extent.x + upright * mix(extent.y, extent.z, corner.y);
    facing = normalize(to_eye + up);
    float turn = atan(dot(to_eye, own_east), dot(to_eye, own_north)) / kTurn;
    int view = views == 1u ? 0 : int(round(turn * float(views)) + float(views)) % int(views);
    vec2 grid = views == 1u ? vec2(1.0) : vec2(4.0, 2.0);
    vec2 origin = vec2(view % 4, view / 4) / grid;
    place = origin + vec2(corner.x, 1.0 - corner.y) / grid;
    cell = vec4(origin, origin + 1.0 / grid);
  }
  from_eye = foot + from_foot * foot_and_scale.w;
  gl_Position = clip_from_eye * vec4(from_eye, 1.0);
}
