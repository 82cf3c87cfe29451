#version 450 core

layout(location = 0) uniform mat4 ray_from_clip;
layout(location = 0) out vec3 ray;

void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  ray = (ray_from_clip * vec4(corner, 0.0, 1.0)).xyz;
  gl_Position = vec4(corner, 0.0, 1.0);  // depth 0: infinitely far
}
