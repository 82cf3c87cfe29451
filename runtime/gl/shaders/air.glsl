// The Earth's air: light of the sun that molecules and haze scatter once, and that ozone takes away. Coefficients are those
// of Bruneton & Neyret 2008 and Hillaire 2020 at 680, 550 and 440 nm; what is scattered more than once is left out. What
// includes this has the uniforms radii, eye_geocentric and to_sun.
const float kTop = 100000.0;               // metres: above it there is no air
const float kMoleculeScale = 8000.0, kHazeScale = 1200.0;  // metres in which their density falls to 1/e
const vec3 kMolecules = vec3(5.802e-6, 13.558e-6, 33.1e-6);  // scattered, per metre at height 0
const float kHazeScatters = 3.996e-6, kHazeTakes = 4.44e-6;
const vec3 kOzoneTakes = vec3(0.650e-6, 1.881e-6, 0.085e-6) * 15000.0;  // straight up through its layer
const float kOzoneHeight = 25000.0;
const float kSunStrength = 18.0;  // exposes the clear sky of noon

// How many scale heights of air at the place's own density a ray meets that leaves it at this cosine of the zenith angle,
// times that density's share of height 0's (Chapman's function as approximated by Schueler 2012).
float air_mass(float planet, float above, float cosine) {
  float c = sqrt(planet + above);
  float here = c / (c * abs(cosine) + 1.0) * exp(-above);
  if (cosine >= 0.0) return here;
  float lowest = sqrt(max(1.0 - cosine * cosine, 0.0)) * (planet + above);
  return 2.0 * sqrt(lowest) * exp(min(planet - lowest, 40.0)) - here;
}

// The share of the sun's light that comes to a height, by the cosine of the sun's zenith angle there.
vec3 sunlight(float planet_radius, float above, float cosine) {
  above = max(above, 0.0);
  float molecules = kMoleculeScale * air_mass(planet_radius / kMoleculeScale, above / kMoleculeScale, cosine);
  float haze = kHazeScale * air_mass(planet_radius / kHazeScale, above / kHazeScale, cosine);
  float aside = (planet_radius + min(above, kOzoneHeight - 100.0)) / (planet_radius + kOzoneHeight);
  float ozone = above < kOzoneHeight ? inversesqrt(max(1.0 - aside * aside * (1.0 - cosine * cosine), 1e-3)) : 0.0;
  return exp(-min(kMolecules * molecules + kHazeTakes * haze + kOzoneTakes * ozone, 80.0));
}

struct Air {
  vec3 scattered;  // light that comes from the air between
  vec3 passes;     // the share of what lies behind that comes through
};

// The air along a ray from the eye, as far as `last` metres.
Air air_along(vec3 d, float last, int steps) {
  // Heights above the ellipsoid, not the sphere, decide how much air there is.
  float planet = (2.0 * radii.x + radii.z) / 3.0;
  vec3 e = eye_geocentric / radii * planet;
  float middle = -dot(e, d);
  float nearest2 = dot(e, e) - middle * middle;
  float outer2 = (planet + kTop) * (planet + kTop);
  Air air = Air(vec3(0.0), vec3(1.0));
  if (nearest2 >= outer2) return air;
  float half_chord = sqrt(outer2 - nearest2);
  float first = max(middle - half_chord, 0.0);
  last = min(last, middle + half_chord);
  if (last <= first) return air;
  float cosine = dot(d, to_sun);
  float molecules_phase = 3.0 / (16.0 * 3.14159265) * (1.0 + cosine * cosine);
  const float g = 0.8;
  float haze_phase = 3.0 / (8.0 * 3.14159265) * (1.0 - g * g) * (1.0 + cosine * cosine) /
                     ((2.0 + g * g) * pow(1.0 + g * g - 2.0 * g * cosine, 1.5));
  // Steps grow with the distance, so that near air is not missed when the ray goes far.
  float begin = 0.0;
  for (int i = 0; i < steps; ++i) {
    float share = (float(i) + 1.0) / float(steps);
    float end = (last - first) * share * share;
    float step_length = end - begin;
    vec3 at = e + d * (first + 0.5 * (begin + end));
    begin = end;
    float r = length(at);
    float above = max(r - planet, 0.0);
    float molecules = exp(-above / kMoleculeScale), haze = exp(-above / kHazeScale);
    vec3 taken = (kMolecules * molecules + kHazeTakes * haze) * step_length;
    vec3 sun = sunlight(planet, above, dot(at, to_sun) / r);
    vec3 scatters = (kMolecules * molecules * molecules_phase + kHazeScatters * haze * haze_phase) * step_length;
    air.scattered += kSunStrength * scatters * sun * air.passes * exp(-0.5 * taken);
    air.passes *= exp(-taken);
  }
  return air;
}

// Light, linear RGB, from radiance: never above 1.
vec3 exposed(vec3 radiance) {
  return 1.0 - exp(-radiance);
}

// What the eye sees of something lit through the air before it. Ground is exposed darker than the sky, as a photographer's
// filter does it; thin air before it likewise, by 0.4, and air that hides it altogether as the sky.
vec3 through_air(vec3 lit, Air air) {
  return lit * air.passes + exposed(air.scattered * mix(1.0, 0.4, air.passes.g));
}
