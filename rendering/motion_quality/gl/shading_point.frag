#version 450 core
// Where a fragment is shaded under a map of shading rates: the centre of its block. To be linked
// with a fragment shader that declares the functions and uses them instead of gl_FragCoord and of
// its interpolated inputs. With hardware shading rates that shader runs once per block; without, once
// per pixel, with the same outcome for all pixels of a block.
// CPU twin: shading_point() in coarse_shading.cpp. Source: thesis (UCAM-CL-TR-977), chapter 6.
//
// Inputs   gl_FragCoord.xy: anywhere in the block, px
//          shading_rates: rate index 1..7 (shading_rate.h) per tile of 16 x 16 px, row 0 first
// Output   shading_point(): px, OpenCV convention (first pixel's centre at 0)
//          at_shading_point(x): an interpolated input, carried on linearly to that point
layout(binding = 15) uniform usampler2D shading_rates;

const ivec2 kBlock_px[8] = ivec2[8](ivec2(1), ivec2(4, 4), ivec2(2, 4), ivec2(4, 2), ivec2(2, 2),
                                    ivec2(1, 2), ivec2(2, 1), ivec2(1, 1));

vec2 shading_point() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  ivec2 tile = min(pixel / 16, textureSize(shading_rates, 0) - 1);
  ivec2 block = kBlock_px[min(texelFetch(shading_rates, tile, 0).r, 7u)];
  return vec2(pixel / block * block) + 0.5 * vec2(block - 1);
}

vec4 at_shading_point(vec4 x) {
  vec2 step_px = shading_point() - (gl_FragCoord.xy - 0.5);
  return x + dFdx(x) * step_px.x + dFdy(x) * step_px.y;
}
