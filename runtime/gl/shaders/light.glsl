// What sun, sky and air make of a colour. REQUIRES: the uniforms to_sun, eye_height and look.

// Air between the eye and a place, as a share of what hides all: density falls off as exp(-height / 8 km).
float haze(float distance, float height) {
  const float kScale = 8000.0, kPerMetre = 1.0 / 300000.0;
  float a = max(eye_height, 0.0) / kScale, b = max(height, 0.0) / kScale;
  float mean = abs(a - b) < 1e-3 ? exp(-a) : (exp(-min(a, b)) - exp(-max(a, b))) / abs(a - b);
  // Above the air the straight line from eye to ground spends little of its length in it.
  return 1.0 - exp(-kPerMetre * distance * mean);
}

// A colour in the light at a place: its normal, the ellipsoid's, the share of the sun's disc that it sees, how far it is from
// the eye and how high above the datum, metres.
vec3 lit_colour(vec3 plain, vec3 normal, vec3 up, float sun_share, float distance, float height) {
  // Without air the terminator is sharp, and what the sun does not reach is dark but for a trace.
  bool earth = (look & 4u) != 0u;
  float day = earth ? smoothstep(-0.12, 0.15, dot(up, to_sun)) : step(-0.02, dot(up, to_sun));
  float sun = max(dot(normal, to_sun), 0.0) * day * sun_share;
  float sky = 0.5 + 0.5 * dot(normal, up);
  vec3 light = earth ? sun * vec3(1.12, 1.06, 0.95) + sky * (0.04 + 0.22 * day) * vec3(0.75, 0.9, 1.15)
                     : vec3(1.4 * sun + 0.015);
  vec3 lit = plain * light;
  if ((look & 2u) != 0u) lit = mix(lit, vec3(0.44, 0.58, 0.78) * (0.03 + 0.97 * day), haze(distance, height));
  return lit;
}
