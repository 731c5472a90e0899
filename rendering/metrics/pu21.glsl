// PU21 encoding of absolute luminance, in shaders: paste it after the #version line.
//
// in   luminance in cd/m^2, clamped to 0.005..10000; variant 0 banding, 1 banding_glare, 2 peaks,
//      3 peaks_glare
// out  PU21 units, about 0..595
// Source    Mantiuk and Azimi, PCS 2021; reference metrics.md, section 1.
// CPU twin  pu21_encode() and pu21_decode() in pu21.cpp. Single precision cancels near the foot of
//           the curve; the tests hold the encoding to 0.002 units plus 1e-5 of the value.
struct Pu21Parameters {
  float p1, p2, p3, p4, p5, p6, p7;
};
const int kPu21BandingGlare = 1;
const Pu21Parameters kPu21Parameters[4] = Pu21Parameters[4](
    Pu21Parameters(1.070275272, 0.4088273932, 0.153224308, 0.2520326168, 1.063512885, 1.14115047,
                   521.4527484),
    Pu21Parameters(0.353487901, 0.3734658629, 8.277049286e-05, 0.9062562627, 0.09150303166,
                   0.9099517204, 596.3148142),
    Pu21Parameters(1.043882782, 0.6459495343, 0.3194584211, 0.374025247, 1.114783422, 1.095360363,
                   384.9217577),
    Pu21Parameters(816.885024, 1479.463946, 0.001253215609, 0.9329636822, 0.06746643971,
                   1.573435413, 419.6006374));

float pu21_encode(float luminance_cd_m2, int variant) {
  Pu21Parameters p = kPu21Parameters[variant];
  float y = pow(clamp(luminance_cd_m2, 0.005, 10000.0), p.p4);
  return max(p.p7 * (pow((p.p1 + p.p2 * y) / (1.0 + p.p3 * y), p.p5) - p.p6), 0.0);
}

vec3 pu21_encode(vec3 rgb_cd_m2, int variant) {
  return vec3(pu21_encode(rgb_cd_m2.r, variant), pu21_encode(rgb_cd_m2.g, variant),
              pu21_encode(rgb_cd_m2.b, variant));
}

float pu21_decode(float pu21, int variant) {
  Pu21Parameters p = kPu21Parameters[variant];
  float v = pow(max(pu21 / p.p7 + p.p6, 0.0), 1.0 / p.p5);
  return pow(max(v - p.p1, 0.0) / (p.p2 - p.p3 * v), 1.0 / p.p4);
}
