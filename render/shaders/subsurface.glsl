// SPDX-License-Identifier: Apache-2.0
// Light that goes below a surface and leaves it beside where it came in (docs/PHYSICS.md, "Subsurface light"). Around a
// place the surface is taken as its tangent plane with the same light all over it, and the projector's coordinates as
// linear: each pair of a pattern is then multiplied by one complex number.

const float REFRACTION = 1.4;  // index of plastics, wax, skin: 1.3 ... 1.6

// What the light that a place sends to the camera has been through; G: px of the projector per mean free path l along
// the surface.
struct Below {
  vec3 spread_px2;  // G G^T as uu, uv, vv
  vec2 light_px;    // G by the tangential part of the way to the light inside, of length 1
  vec2 viewer_px;   // the same to the viewer
  vec2 cosines;     // of both ways inside and the normal
  float lost;       // 3 (1 - share of the light that a scattering event leaves)
  float share;      // of the light that has been inside; the lobe has not
  float scale;      // of the profile over l; for codes, which the adaptive trace has none of
};
const Below NEVER_BELOW = Below(vec3(0.0), vec2(0.0), vec2(0.0), vec2(1.0), 3.0, 0.0, 0.0);
Below below = NEVER_BELOW;  // of the hit last shaded

#define PACK_BELOW(to, at)                                           \
  to[at] = vec4(below.spread_px2, below.lost);                       \
  to[at + 1] = vec4(below.light_px, below.viewer_px);                \
  to[at + 2] = vec4(below.cosines, below.share, 0.0);
Below unpack_below(vec4 a, vec4 b, vec4 c) { return Below(a.xyz, b.xy, b.zw, c.xy, a.w, c.z, 0.0); }

vec2 complex_product(vec2 a, vec2 b) { return vec2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x); }

// Along an axis of the projector's image.
float below_spread_px2(vec2 axis) {
  return axis.x * axis.x * below.spread_px2.x + 2.0 * axis.x * axis.y * below.spread_px2.y +
         axis.y * axis.y * below.spread_px2.z;
}

// What exp(i k x) along an axis of the projector's image becomes, relative to itself at the place; k: rad per px.
vec2 kept_below(float k, vec2 axis) {
  float k2 = k * k * below_spread_px2(axis);
  vec2 all = vec2(sqrt(k2 + 3.0), 0.0), left = vec2(sqrt(k2 + below.lost), 0.0);
  vec2 a = vec2(1.0, -k * dot(axis, below.light_px)) / below.cosines.x;
  vec2 b = vec2(1.0, k * dot(axis, below.viewer_px)) / below.cosines.y;
  vec2 top = complex_product(a + all, b + all), bottom = complex_product(complex_product(a + left, b + left), a + b);
  float a0 = 1.0 / below.cosines.x, b0 = 1.0 / below.cosines.y, left0 = sqrt(below.lost);
  float uniform_light = (a0 + 1.7320508) * (b0 + 1.7320508) / ((a0 + left0) * (b0 + left0) * (a0 + b0));
  return complex_product(top, vec2(bottom.x, -bottom.y)) / (dot(bottom, bottom) * uniform_light);
}

vec2 pair_from_below(int i) {
  vec4 pitch = params.pitch[i];
  return vec2(1.0 - below.share, 0.0) + below.share * kept_below(TWO_PI * pitch.x, pitch.zw);
}

// By how much the middle of where light came in lies beside the place along an axis, px: for edges, that of a wave of
// 1 rad per mean free path.
float entered_beside_px(vec2 axis) {
  float k = inversesqrt(max(below_spread_px2(axis), 1e-12));
  vec2 kept = kept_below(k, axis);
  return atan(kept.y, kept.x) / k;
}

// Share of the light that scattering takes, 1 - share = s^2, of a half space with an albedo A: van de Hulst,
// A = (1 - s)(1 - 0.139 s)/(1 + 1.17 s), solved for s.
float scattering_of_albedo(float albedo) {
  float dark = max(1.0 - albedo, 0.0), b = 1.139 + 1.17 * albedo;
  return 2.0 * dark / (b + sqrt(b * b - 0.556 * dark));
}

// The profile along an axis as normal distributions, for edges. Profile: Christensen and Burley, "Approximate Reflectance
// Profiles for Efficient Subsurface Scattering", Pixar 15-04, 2015, of the scale d = l/(1.85 - A + 7 |A - 0.8|^3).
// Variances in units of d^2 and shares, fitted to the light beside an edge (off by 0.002 of its height at most).
#define BELOW_NORMALS 4
const float BELOW_VARIANCE[BELOW_NORMALS] = float[BELOW_NORMALS](0.00300053, 0.14105391, 1.96617426, 18.566266);
const float BELOW_SHARE[BELOW_NORMALS] = float[BELOW_NORMALS](0.05892567, 0.21645243, 0.42661349, 0.29800841);
// Of these the one that is being evaluated, times (d/l)^2.
float below_variance = 0.0;

float profile_scale(float albedo) {
  float from = abs(albedo - 0.8);
  return 1.0 / (1.85 - albedo + 7.0 * from * from * from);
}
