#version 450 core
// Buffers of a frame, reduced to one value per tile of 16 x 16 px; one tile per invocation.
// CPU twin: reduce_to_tiles() in tile_reduction.cpp. Source: thesis (UCAM-CL-TR-977), section 6.3;
// reference motion_quality.md, section 4, "Tile inputs".
//
// Inputs   motion: rg = motion in x and y since the frame before, px
//          material_mip: r = material index from 0, g = mip level
//          light: rgb = linear light of the frame before, cd/m^2
//          deg_per_s_per_px: refresh rate / pixels per degree
// Outputs  speed_luminance: r, g = mean magnitude of speed in x and y, deg/s; b = mean luminance
//          plus 0.01, cd/m^2
//          material: r = most frequent material of 16 samples, g = smallest mip level among them
layout(binding = 0) uniform sampler2D motion;
layout(binding = 1) uniform isampler2D material_mip;
layout(binding = 2) uniform sampler2D light;
layout(location = 0) uniform float deg_per_s_per_px;
layout(location = 0) out vec4 speed_luminance;
layout(location = 1) out ivec4 material;

const vec3 kLuminanceWeights = vec3(0.212656, 0.715158, 0.072186);

void main() {
  ivec2 size = textureSize(motion, 0);
  ivec2 first = ivec2(gl_FragCoord.xy) * 16;
  ivec2 end = min(first + 16, size);

  vec2 speed = vec2(0.0);
  float luminance = 0.0;
  for (int y = first.y; y < end.y; ++y)
    for (int x = first.x; x < end.x; ++x) {
      speed += abs(texelFetch(motion, ivec2(x, y), 0).rg);
      luminance += dot(texelFetch(light, ivec2(x, y), 0).rgb, kLuminanceWeights);
    }
  float pixels = float((end.x - first.x) * (end.y - first.y));
  speed_luminance = vec4(speed / pixels * deg_per_s_per_px, luminance / pixels + 0.01, 0.0);

  ivec2 samples[16];
  for (int i = 0; i < 16; ++i)
    samples[i] = texelFetch(material_mip,
                            min(first + 2 + 4 * ivec2(i % 4, i / 4), size - 1), 0).rg;
  int most = 0;
  material = ivec4(0);
  for (int i = 0; i < 16; ++i) {
    int count = 0, mip = samples[i].g;
    for (int k = 0; k < 16; ++k)
      if (samples[k].r == samples[i].r) {
        ++count;
        mip = min(mip, samples[k].g);
      }
    if (count > most) {
      most = count;
      material = ivec4(samples[i].r, mip, 0, 0);
    }
  }
}
