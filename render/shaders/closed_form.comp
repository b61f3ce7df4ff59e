#version 460
// SPDX-License-Identifier: Apache-2.0
// From the centre rays to the average over the pixel's square, without further rays, where one surface
// fills the neighbourhood; else the class of the pixel. docs/PHYSICS.md derives the formulas.
//
// Inside the pixel, theta(x,y) = theta0 + g.(x,y) + second order, w = w0 + first + second order. The
// average of w exp(i theta) over the square is exact in the phase gradient g (moments of exp(i g x)) and
// of second order in everything else. Derivatives come from five-point differences along x and y.
#extension GL_GOOGLE_include_directive : require
#include "bindings.glsl"
#include "camera.glsl"
#include "shapes.glsl"
#include "mesh.glsl"
#include "scene.glsl"
#include "projector.glsl"
#include "patterns.glsl"
#include "work_items.glsl"
#include "identity.glsl"

layout(local_size_x = BLOCK_WIDTH, local_size_y = BLOCK_HEIGHT) in;

// Moments of exp(i h s) over s in [-1, 1]: <1> = m.x, <s> = i m.y, <s^2> = m.z. Series below 1, where the
// closed forms cancel; the first dropped terms are below 3e-8.
vec3 moments(float h) {
  float q = h * h;
  vec3 series = vec3(1.0 + q * (-1.0 / 6.0 + q * (1.0 / 120.0 + q * (-1.0 / 5040.0 + q / 362880.0))),
                     h * (1.0 / 3.0 + q * (-1.0 / 30.0 + q * (1.0 / 840.0 + q * (-1.0 / 45360.0 + q / 3991680.0)))),
                     1.0 / 3.0 + q * (-1.0 / 10.0 + q * (1.0 / 168.0 + q * (-1.0 / 6480.0 + q / 443520.0))));
  float s = sin(h), c = cos(h), inv = 1.0 / h;
  vec3 closed = vec3(s * inv, (s * inv - c) * inv, (s + 2.0 * (c - s * inv) * inv) * inv);
  return abs(h) < 1.0 ? series : closed;
}

// What the light of a pixel's centre ray has been through, as probe.comp wrote it.
Below below_at(ivec2 pixel) {
  if (!in_image(pixel)) return NEVER_BELOW;
  int at = int(params.image.x * params.image.y) + PROBE_MORE * (pixel.y * int(params.image.x) + pixel.x);
  return unpack_below(texelFetch(probe, at), texelFetch(probe, at + 1), texelFetch(probe, at + 2));
}

vec2 pair_of(Below place, int i) {
  below = place;
  return pair_from_below(i);
}

struct Derivatives {
  vec3 x, y, xx, xy, yy;     // of (u, w) per px
  vec3 third_x, third_y, fourth_x, fourth_y;
};

void main() {
  params = params_block.values;
  uvec2 pixel_u = block_pixel();
  ivec2 pixel = ivec2(pixel_u);
  uint slot = own_slot(), stride = push.n_blocks_band * BLOCK_PIXELS;
  vec4 c = in_image(pixel) ? probe_at(pixel) : vec4(0.0);

  // The neighbourhood: nine identities, and two more along each axis.
  vec4 near[9], far[4];
  bool inside = true, at_border = !in_image(pixel - 1) || !in_image(pixel + 1);
#define LOAD_NEAR(k)                                             \
  {                                                              \
    ivec2 q = pixel + ivec2(k % 3 - 1, k / 3 - 1);               \
    inside = inside && in_image(q);                              \
    near[k] = in_image(q) ? probe_at(q) : c;                     \
  }
  LOAD_NEAR(0) LOAD_NEAR(1) LOAD_NEAR(2) LOAD_NEAR(3) LOAD_NEAR(4) LOAD_NEAR(5) LOAD_NEAR(6) LOAD_NEAR(7) LOAD_NEAR(8)
  const ivec2 steps[4] = ivec2[4](ivec2(-2, 0), ivec2(2, 0), ivec2(0, -2), ivec2(0, 2));
#define LOAD_FAR(k)                                 \
  {                                                 \
    ivec2 q = pixel + steps[k];                     \
    inside = inside && in_image(q);                 \
    far[k] = in_image(q) ? probe_at(q) : c;         \
  }
  LOAD_FAR(0) LOAD_FAR(1) LOAD_FAR(2) LOAD_FAR(3)

  // One mesh and nothing else around? Meshes come last among the primitives.
  int mesh = -1;
#define LAST_PRIMITIVE(k) mesh = max(mesh, near[k].w != 0.0 ? primitive_of(near[k].w) : -1);
  LAST_PRIMITIVE(0) LAST_PRIMITIVE(1) LAST_PRIMITIVE(2) LAST_PRIMITIVE(3) LAST_PRIMITIVE(4) LAST_PRIMITIVE(5)
  LAST_PRIMITIVE(6) LAST_PRIMITIVE(7) LAST_PRIMITIVE(8)
  bool mesh_alone = N_MESHES > 0 && linked(LINKS_WALK) && N_DIRECT == 0 && inside && mesh >= FIRST_MESH;

  bool any_light = false, any_hit = false, all_lit = true, all_hit = true, same = true, same_far = inside;
  int own_primitive = primitive_of(c.w);
  bool one_mesh = N_MESHES > 0 && own_primitive >= FIRST_MESH;
#define LOOK_NEAR(k)                                                    \
  any_light = any_light || near[k].w > 0.0;                             \
  any_hit = any_hit || near[k].w != 0.0;                                \
  all_lit = all_lit && near[k].w > 0.0;                                 \
  all_hit = all_hit && near[k].w != 0.0;                                \
  same = same && near[k].w == c.w;                                      \
  mesh_alone = mesh_alone && (near[k].w == 0.0 || primitive_of(near[k].w) == mesh); \
  one_mesh = one_mesh && near[k].w > 0.0 && primitive_of(near[k].w) == own_primitive;
  LOOK_NEAR(0) LOOK_NEAR(1) LOOK_NEAR(2) LOOK_NEAR(3) LOOK_NEAR(4) LOOK_NEAR(5) LOOK_NEAR(6) LOOK_NEAR(7) LOOK_NEAR(8)
#define LOOK_FAR(k) same_far = same_far && far[k].w == c.w;
  LOOK_FAR(0) LOOK_FAR(1) LOOK_FAR(2) LOOK_FAR(3)

  int changes_x = 0, changes_y = 0;
#define CHANGE(a, b, n) n += near[a].w != near[b].w ? 1 : 0;
  CHANGE(0, 1, changes_x) CHANGE(1, 2, changes_x) CHANGE(3, 4, changes_x) CHANGE(4, 5, changes_x)
  CHANGE(6, 7, changes_x) CHANGE(7, 8, changes_x)
  CHANGE(0, 3, changes_y) CHANGE(3, 6, changes_y) CHANGE(1, 4, changes_y) CHANGE(4, 7, changes_y)
  CHANGE(2, 5, changes_y) CHANGE(5, 8, changes_y)

  bool ambient = params.adaptive.z > 0.0;
  int kind = PIXEL_DONE;
  // Gray and other images need the samples' own footprints.
  int on_mesh = N_GRAY + N_IMAGES > 0 ? PIXEL_SMOOTH : PIXEL_FACETS;
  // Beside a crease or the image border the five-point differences fail.
  if (!(same && same_far)) kind = one_mesh ? on_mesh : PIXEL_SMOOTH;
  if (!same) kind = one_mesh ? on_mesh : changes_y > changes_x ? PIXEL_MIXED_Y : PIXEL_MIXED;
  if (!same && !one_mesh && mesh_alone) kind = changes_y > changes_x ? PIXEL_OUTLINE_Y : PIXEL_OUTLINE;
  // An edge may come in from where no ray looks.
  if (at_border && any_light) kind = changes_y > changes_x ? PIXEL_MIXED_Y : PIXEL_MIXED;
  // Nothing lit: only ambient light can tell one unlit surface from another or from nothing.
  if (!any_light && (!ambient || all_hit || !any_hit)) kind = PIXEL_DONE;

  Below below_here = NEVER_BELOW, below_left = NEVER_BELOW, below_right = NEVER_BELOW, below_up = NEVER_BELOW,
        below_down = NEVER_BELOW;
  if (SUBSURFACE != 0) {
    below_here = below_at(pixel);
    below_left = below_at(pixel - ivec2(1, 0));
    below_right = below_at(pixel + ivec2(1, 0));
    below_up = below_at(pixel - ivec2(0, 1));
    below_down = below_at(pixel + ivec2(0, 1));
  }
  Derivatives d;
  vec3 v0 = c.xyz, xm = near[3].xyz, xp = near[5].xyz, ym = near[1].xyz, yp = near[7].xyz;
  vec3 xm2 = far[0].xyz, xp2 = far[1].xyz, ym2 = far[2].xyz, yp2 = far[3].xyz;
  d.x = (8.0 * (xp - xm) - (xp2 - xm2)) / 12.0;
  d.y = (8.0 * (yp - ym) - (yp2 - ym2)) / 12.0;
  d.xx = (16.0 * ((xp - v0) + (xm - v0)) - ((xp2 - v0) + (xm2 - v0))) / 12.0;
  d.yy = (16.0 * ((yp - v0) + (ym - v0)) - ((yp2 - v0) + (ym2 - v0))) / 12.0;
  d.xy = ((near[8].xyz - near[2].xyz) - (near[6].xyz - near[0].xyz)) / 4.0;
  d.third_x = ((xp2 - xm2) - 2.0 * (xp - xm)) / 2.0;
  d.third_y = ((yp2 - ym2) - 2.0 * (yp - ym)) / 2.0;
  d.fourth_x = ((xp2 - v0) + (xm2 - v0)) - 4.0 * ((xp - v0) + (xm - v0));
  d.fourth_y = ((yp2 - v0) + (ym2 - v0)) - 4.0 * ((yp - v0) + (ym - v0));

  float fill = params.sampling.x, half_fill = 0.5 * fill, q = half_fill * half_fill;
  bool lit = kind == PIXEL_DONE && c.w > 0.0;
  float w0 = lit ? c.z : 0.0;
  float mean = w0 + (lit ? q / 6.0 * (d.xx.z + d.yy.z) : 0.0);
  float cosine[MAX_PITCHES], sine[MAX_PITCHES];
  // Errors of what is left out, pixel units: fourth derivatives (their own term in the average is 1/1920,
  // in the second differences 1/2160; 1/300 leaves a margin for what grows with the order), and products
  // of lower ones.
  float shading_error = (abs(d.fourth_x.z) + abs(d.fourth_y.z)) / 300.0;
  // Those of a pitch and its harmonics add up.
  float phase_error = 0.0, gray_error = shading_error, swing_sq = 0.0, chain = 0.0;
#define FORM_PITCH(i)                                                                                    \
  if (i < N_PITCHES) {                                                                                   \
    vec4 pitch = params.pitch[i];                                                                        \
    float turns = dot(pitch.zw, v0.xy) * pitch.x + pitch.y;                                              \
    float theta = TWO_PI * (turns - floor(turns + 0.5));                                                 \
    float k = TWO_PI * pitch.x;                                                                          \
    float gx = k * dot(pitch.zw, d.x.xy), gy = k * dot(pitch.zw, d.y.xy);                                \
    float hxx = k * dot(pitch.zw, d.xx.xy), hxy = k * dot(pitch.zw, d.xy.xy), hyy = k * dot(pitch.zw, d.yy.xy); \
    vec3 mx = moments(gx * half_fill), my = moments(gy * half_fill);                                     \
    float xx = mx.z * my.x, xy = -mx.y * my.y, yy = mx.x * my.z;                                         \
    float re = w0 * mx.x * my.x + q * (0.5 * d.xx.z * xx + d.xy.z * xy + 0.5 * d.yy.z * yy);             \
    float im = half_fill * (d.x.z * mx.y * my.x + d.y.z * mx.x * my.y) +                                 \
               w0 * q * (0.5 * hxx * xx + hxy * xy + 0.5 * hyy * yy);                                    \
    float s = sin(theta), co = cos(theta);                                                               \
    if (SUBSURFACE != 0) { /* a factor that is linear over the pixel, like the shading, but complex */    \
      vec2 here = pair_of(below_here, i), left = pair_of(below_left, i), right = pair_of(below_right, i); \
      vec2 up = pair_of(below_up, i), down = pair_of(below_down, i);                                     \
      vec2 x = 0.5 * (right - left), y = 0.5 * (down - up);                                              \
      vec2 bend = abs(right + left - 2.0 * here) + abs(down + up - 2.0 * here);                          \
      float left_out = length(bend) * fill * fill / 24.0;                                                \
      gray_error = max(gray_error, shading_error + w0 * left_out);                                       \
      phase_error = max(phase_error, SHARE(i) * left_out / max(length(here), 1e-3));                     \
      vec2 slope = half_fill * w0 * (mx.y * my.x * x + mx.x * my.y * y);                                 \
      vec2 light = complex_product(vec2(re, im), here) + vec2(-slope.y, slope.x);                        \
      re = light.x;                                                                                      \
      im = light.y;                                                                                      \
    }                                                                                                    \
    cosine[i] = lit ? re * co - im * s : 0.0;                                                            \
    sine[i] = lit ? re * s + im * co : 0.0;                                                              \
    float third_x = k * abs(dot(pitch.zw, d.third_x.xy)), third_y = k * abs(dot(pitch.zw, d.third_y.xy)); \
    float fourth = k * (abs(dot(pitch.zw, d.fourth_x.xy)) + abs(dot(pitch.zw, d.fourth_y.xy)));          \
    float bend = abs(hxx) + abs(hyy) + abs(hxy);                                                         \
    float e = fourth / 300.0 + (abs(d.x.z) * third_x + abs(d.y.z) * third_y) / (240.0 * w0) +            \
              bend * (abs(d.xx.z) + abs(d.yy.z)) / (300.0 * w0) +                                        \
              (abs(gx) + abs(gy)) * (abs(d.third_x.z) + abs(d.third_y.z)) / (240.0 * w0);                \
    float a = (abs(gx) * third_x + abs(gy) * third_y) / 240.0 + bend * bend / 300.0 +                    \
              bend * (abs(gx) * abs(d.x.z) + abs(gy) * abs(d.y.z)) / (160.0 * w0);                       \
    /* Where Gauss-Legendre of order n stands in for the closed form, its error in the phase gradient. */ \
    float g2 = max(gx * gx, gy * gy) * fill * fill;                                                      \
    swing_sq = max(swing_sq, SHARE(i) * g2);                                                             \
    if (params.adaptive.w == 2.0) a += g2 * g2 / 2160.0;                                                 \
    if (params.adaptive.w == 3.0) a += g2 * g2 * g2 / 1.0e6;                                             \
    phase_error = max(phase_error, SHARE(i) * e);                                                        \
    if ((FUNDAMENTALS & (1 << i)) != 0) chain = 0.0;                                                     \
    chain += SHARE(i) * (e + a);                                                                         \
    gray_error = max(gray_error, shading_error + w0 * chain);                                            \
  }
  REPEAT32(FORM_PITCH)
  // Also catches NaN and infinity.
  bool good = phase_error <= params.adaptive.x && gray_error <= params.adaptive.y;
  if (lit && !good) kind = PIXEL_SMOOTH;
  // Low orders say nothing about several fringes in a pixel. (Differences at the image's border are half.)
  bool along_y = length(d.y.xy) > length(d.x.xy);
  if ((kind == PIXEL_SMOOTH && swing_sq > 2.25) || (kind == PIXEL_FACETS && swing_sq > MOST_FACET_SWING * MOST_FACET_SWING)) kind = along_y ? PIXEL_MIXED_Y : PIXEL_MIXED;

  bool done = kind == PIXEL_DONE;
  sums[slot] = done ? mean : 0.0;
  sums[slot + stride] = done && c.w != 0.0 ? 1.0 : 0.0;
#define STORE_FORMED(i)                                          \
  if (i < N_PITCHES) {                                           \
    sums[slot + (2 + 2 * i) * stride] = done ? cosine[i] : 0.0;  \
    sums[slot + (3 + 2 * i) * stride] = done ? sine[i] : 0.0;    \
  }
  REPEAT32(STORE_FORMED)
  sums[slot + (2 + 2 * N_PITCHES + N_DIRECT) * stride] = done && lit ? phase_error : 0.0;
  sums[slot + (3 + 2 * N_PITCHES + N_DIRECT) * stride] = done && lit ? gray_error : 0.0;
  objects[slot] = kind;
}
