// Water over what lies below `sea_level`: the surface is where the line of sight meets the ellipsoid at that height, so that
// it needs no triangles. What includes this includes light.glsl and has the uniform sea_level.

// How far the surface is along a ray from the eye; < 0 where the ray misses it, and from below it.
float distance_to_sea(vec3 d) {
  vec3 r = radii + sea_level;
  vec3 e = eye_geocentric / r, s = d / r;
  float a = dot(s, s), b = dot(e, s), c = dot(e, e) - 1.0;
  if (b >= 0.0 || c <= 0.0) return -1.0;
  float root = b * b - a * c;
  return root < 0.0 ? -1.0 : c / (-b + sqrt(root));
}

// Water at a distance along a ray; `below`, the lit colour of the ground under it, seen through `through` metres of water;
// negative where no ground is known.
vec3 water_colour(vec3 d, float distance, vec3 below, float through, float sun_share) {
  vec3 up = normalize((eye_geocentric + d * distance) / (radii * radii));
  float height_of_sun = dot(up, to_sun);
  float planet = (2.0 * radii.x + radii.z) / 3.0;
  float day = smoothstep(-0.12, 0.15, height_of_sun);
  vec3 sun = sunlight(planet, sea_level, height_of_sun) * sun_share;
  // Clear ocean water takes red first (Pope & Fry 1997: some 0.45, 0.06 and 0.02 per metre), coasts take more.
  vec3 passes = through < 0.0 ? vec3(0.0) : exp(-through * vec3(0.35, 0.09, 0.06));
  vec3 own = vec3(0.004, 0.028, 0.055) * (0.1 + 0.9 * day);
  vec3 inside = below * passes + own * (1.0 - passes);
  // What a rough surface mirrors: the sky towards the horizon, by Fresnel's law (Schlick 1994), and the sun as a glint
  // whose width is that of waves in a wind of some 5 m/s (Cox & Munk 1954).
  float facing = max(dot(-d, up), 0.0);
  float mirrored = 0.02 + 0.98 * pow(1.0 - max(facing, 0.06), 5.0);
  vec3 reflected = reflect(d, up);
  vec3 sky = exposed(air_along(normalize(reflected + 0.1 * up), 1e7, 6).scattered);
  vec3 middle = normalize(to_sun - d);
  float tilt2 = max(1.0 / pow(max(dot(middle, up), 1e-3), 2.0) - 1.0, 0.0);
  const float kSlopes = 0.028;
  float glint = height_of_sun > -0.02 ? exp(-tilt2 / kSlopes) / (4.0 * kSlopes) * 0.02 / max(facing, 0.15) : 0.0;
  vec3 seen = mix(inside, sky, mirrored) + sun * min(glint, 4.0);
  if ((look & 2u) == 0u) return min(seen, 1.0);
  Air air = air_along(d, distance, 5);
  return through_air(min(seen, 1.0), air);
}
