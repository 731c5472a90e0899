#version 450 core
// A picture as it looks when shaded at the rates of a map: each block has the picture's value at
// the block's centre. Linked with shading_point.frag. CPU twin: shade_picture_coarsely() in
// coarse_shading.cpp. Source: thesis (UCAM-CL-TR-977), chapter 6.
//
// Inputs   picture: linear light, cd/m^2, image row 0 first, bilinear, edge clamped
// Output   rgb: linear light, cd/m^2
layout(binding = 0) uniform sampler2D picture;
layout(location = 0) out vec4 light;

vec2 shading_point();

void main() {
  vec2 size = vec2(textureSize(picture, 0));
  light = vec4(textureLod(picture, (shading_point() + 0.5) / size, 0.0).rgb, 1.0);
}
