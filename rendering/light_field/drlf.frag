#version 450 core
// Dynamically reparameterised light field, one virtual pixel per invocation.
// CPU twin: render_drlf_cpu() in drlf.cpp. Source: Isaksen et al. 2000 and the reference
// drlf_lumigraph.md (3x3 form of Eq. 7.2-7.3).
//
// Inputs   gl_FragCoord.xy - 0.5: virtual pixel, OpenCV convention
//          views: data images, linear light times light_scale, image row 0 first
//          cameras: rows of H_data_virtual; (s, t) of the camera on the aperture, mm;
//          width and height of its picture, px, in the corner of its layer
//          cells: affine weights a.(s,t,1) of up to 3 cameras; w of `cameras` is their count
//          aperture_rows: virtual pixel to (s h, t h, h); inverse_depth_row: > 0 in front
// Output   rgb: linear light, cd/m^2; a: coverage 0..1
struct Camera {
  vec4 row0, row1, row2;
  vec4 st;
};
struct Cell {
  vec4 a[3];
  ivec4 cameras;
};
layout(std430, binding = 0) readonly buffer Cameras { Camera cameras[]; };
layout(std430, binding = 1) readonly buffer Cells { Cell cells[]; };
layout(binding = 0) uniform sampler2DArray views;
layout(location = 0) uniform vec3 aperture_rows[3];
layout(location = 3) uniform vec3 inverse_depth_row;
layout(location = 4) uniform int aperture;  // 0 nearest, 1 linear, 2 Gaussian
layout(location = 5) uniform int camera_count;
layout(location = 6) uniform int cell_count;
layout(location = 7) uniform float sigma_mm;
layout(location = 8) uniform float feather_px;
layout(location = 9) uniform float light_scale;
layout(location = 0) out vec4 light_and_coverage;

const float kHuge = 3.0e38;

// rgb: light of one camera; a: how much it sees the point, 0..1.
vec4 fetch(int index, vec3 pixel) {
  Camera c = cameras[index];
  vec3 q = vec3(dot(c.row0.xyz, pixel), dot(c.row1.xyz, pixel), dot(c.row2.xyz, pixel));
  if (!(q.z > 0.0)) return vec4(0.0);
  vec2 p = q.xy / q.z;
  vec2 size = c.st.zw;
  vec2 border = min(p, size - 1.0 - p) + 0.5;
  float seen = clamp(min(border.x, border.y) / max(feather_px, 1e-6), 0.0, 1.0);
  if (!(seen > 0.0)) return vec4(0.0);
  // Up to half a pixel beyond the picture's own edge, which need not be the layer's.
  vec2 at = (clamp(p, vec2(0.0), size - 1.0) + 0.5) / vec2(textureSize(views, 0).xy);
  return vec4(textureLod(views, vec3(at, float(index)), 0.0).rgb / light_scale, seen);
}

float squared_distance(int index, vec2 st) {
  vec2 d = cameras[index].st.xy - st;
  return dot(d, d);
}

void main() {
  vec3 pixel = vec3(gl_FragCoord.xy - 0.5, 1.0);
  light_and_coverage = vec4(0.0);
  if (!(dot(inverse_depth_row, pixel) > 0.0)) return;
  vec3 homogeneous = vec3(dot(aperture_rows[0], pixel), dot(aperture_rows[1], pixel),
                          dot(aperture_rows[2], pixel));
  float h = homogeneous.z;
  vec2 st = homogeneous.xy / (h < 0.0 ? min(h, -1e-6) : max(h, 1e-6));

  vec3 sum = vec3(0.0);
  float seen_weight = 0.0, total_weight = 0.0;
  if (aperture == 1) {
    int best_cell = 0;
    vec3 best = vec3(0.0);
    float best_smallest = -kHuge;
    for (int i = 0; i < cell_count; ++i) {
      vec3 w = vec3(0.0);
      float smallest = kHuge;
      for (int k = 0; k < cells[i].cameras.w; ++k) {
        w[k] = dot(cells[i].a[k].xyz, vec3(st, 1.0));
        smallest = min(smallest, w[k]);
      }
      if (smallest > best_smallest) {
        best_smallest = smallest;
        best_cell = i;
        best = w;
      }
    }
    best = max(best, 0.0);
    best /= best.x + best.y + best.z;
    for (int k = 0; k < cells[best_cell].cameras.w; ++k) {
      vec4 light = fetch(cells[best_cell].cameras[k], pixel);
      sum += best[k] * light.a * light.rgb;
      seen_weight += best[k] * light.a;
    }
    total_weight = 1.0;
  } else if (aperture == 2) {
    float nearest = kHuge;
    for (int i = 0; i < camera_count; ++i) nearest = min(nearest, squared_distance(i, st));
    for (int i = 0; i < camera_count; ++i) {
      float w = exp((nearest - squared_distance(i, st)) / (2.0 * sigma_mm * sigma_mm));
      vec4 light = fetch(i, pixel);
      sum += w * light.a * light.rgb;
      seen_weight += w * light.a;
      total_weight += w;
    }
  } else {
    float nearest = kHuge;
    for (int i = 0; i < camera_count; ++i) {
      float d = squared_distance(i, st);
      if (d >= nearest) continue;
      vec4 light = fetch(i, pixel);
      if (light.a <= 0.0) continue;
      nearest = d;
      sum = light.a * light.rgb;
      seen_weight = light.a;
      total_weight = 1.0;
    }
  }
  float coverage = total_weight > 0.0 ? seen_weight / total_weight : 0.0;
  if (coverage > 1e-6) light_and_coverage = vec4(sum / seen_weight, coverage);
}
