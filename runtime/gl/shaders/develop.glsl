// From light to what the picture has. What includes this has the uniform look.
layout(location = 14) uniform float exposure;  // 1: as the light is

// Noise from 0 to 1 that depends on the pixel alone (interleaved gradient noise, Jimenez 2014).
float screen_noise() {
  return fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
}

// Returns a colour, linear RGB, with noise of one step of 8 bits in sRGB from end to end, so that slow gradients show no
// bands.
vec3 dithered(vec3 colour) {
  float noise = screen_noise() - 0.5;
  // The slope of sRGB's curve, 1.055 c^(1/2.4) and 12.92 c, the other way round.
  vec3 step_size = max(vec3(1.0 / 12.92), 2.2 * sqrt(colour)) / 255.0;
  return max(colour + noise * step_size, 0.0);
}

vec4 developed(vec3 light) {
  light *= exposure;
  return vec4((look & 8u) != 0u ? dithered(light) : light, 1.0);
}
