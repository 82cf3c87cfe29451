// What light a place of the ground, or of what stands on it, has: the one function that all shaders of lit things call.
// What includes this has the uniforms radii, eye_geocentric, to_sun and look.
#include "air.glsl"

// The colour, linear RGB, that the eye sees of a matte surface: `albedo` its colour, `normal` and `up` unit vectors,
// `above` its height in metres, `from_eye` its place, `sun_share` the share of the sun that nothing hides.
vec3 seen_colour(vec3 albedo, vec3 normal, vec3 up, float above, vec3 from_eye, float sun_share) {
  float facing = max(dot(normal, to_sun), 0.0) * sun_share;
  float height_of_sun = dot(up, to_sun);
  // Without air the terminator is sharp, and what the sun does not reach is dark but for a trace.
  if ((look & 4u) == 0u) return albedo * (1.4 * facing * step(-0.02, height_of_sun) + 0.015);
  float planet = (2.0 * radii.x + radii.z) / 3.0;
  float day = smoothstep(-0.12, 0.15, height_of_sun);
  vec3 direct = 1.35 * sunlight(planet, above, height_of_sun);
  float sky = 0.5 + 0.5 * dot(normal, up);
  // Light of the sky turns from blue to the violet of dusk as the sun sinks.
  vec3 dusk = mix(vec3(0.85, 0.85, 1.15), vec3(0.75, 0.9, 1.15), smoothstep(0.0, 0.3, height_of_sun));
  vec3 lit = albedo * (facing * direct + sky * (0.015 + 0.245 * day) * dusk);
  if ((look & 2u) == 0u) return lit;
  float distance = length(from_eye);
  Air air = air_along(from_eye / max(distance, 1e-3), distance, 5);
  return through_air(lit, air);
}
