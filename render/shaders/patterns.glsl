// SPDX-License-Identifier: Apache-2.0
// What the sums collect: w cos, w sin per pitch and harmonic; w * value per directly evaluated image.
// Output channels: mean, hit fraction, (cosine, sine) per pair, direct images. Higher harmonics follow
// their fundamental and come from it by the addition theorem, without another cosine.

#include "subsurface.glsl"

const float MOST_FOOTPRINT_WORDS = 32.0;  // wider footprints (grazing, or far too fine a code) count as that
const float MOST_FOOTPRINT_PX = 16.0;     // of an image

// The sample's share of the pixel, projected (px of the projector): its middle as seen from the sample and
// two half sides. All 0: a point. Set by footprint.glsl.
vec2 footprint_middle = vec2(0.0), footprint_x = vec2(0.0), footprint_y = vec2(0.0);
// Variance of the projector's coordinates over what a direction from a surface stands for, px^2; bounce.glsl.
vec2 spread_px2 = vec2(0.0);

// What an error of a pair counts, of one of its fundamental.
#define SHARE(i) ((FUNDAMENTALS & (1 << i)) != 0 ? 1.0 : params.pitch_share[i / 4][i % 4])

// rad per projector px of the finest fringe, harmonics by what they change in the light.
float finest_fringe() {
  float finest = 0.0;
#define FINEST(i) \
  if (i < N_PITCHES) finest = max(finest, SHARE(i) * TWO_PI * params.pitch[i].x);
  REPEAT32(FINEST)
  return finest;
}
// The same for rules whose error grows with the fourth power of the swing.
float finest_swing() {
  float finest = 0.0;
#define FINEST_SWING(i) \
  if (i < N_PITCHES) finest = max(finest, sqrt(sqrt(SHARE(i))) * TWO_PI * params.pitch[i].x);
  REPEAT32(FINEST_SWING)
  return finest;
}

// Normal distribution; Abramowitz and Stegun 7.1.26 (8e-8).
float normal_cdf(float z) {
  float x = abs(z) * 0.70710678, t = 1.0 / (1.0 + 0.3275911 * x);
  float tail = t * (0.254829592 + t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027 + t * 1.061405429))));
  tail *= 0.5 * exp(-x * x);
  return z > 0.0 ? 1.0 - tail : tail;
}
float normal_cdf_integral(float z) { return z * normal_cdf(z) + 0.398942280 * exp(-0.5 * z * z); }

// Share of the footprint (half sides `wide` >= `narrow` along the pattern's axis) left of an edge at
// distance d from its middle. A sharp edge: the sum of two uniform variables, exactly. A blurred one:
// uniform plus normal, the narrow side taken as normal of its variance: off by at most 0.01 narrow/wide.
float share_left(float d, float wide, float narrow, float sigma) {
  if (GRAY_BLUR != 0) {
    float w = max(wide, 0.05 * sigma);  // narrower ones cancel; the variance keeps its sum
    float s = sqrt(max(sigma * sigma + (narrow * narrow + wide * wide - w * w) / 3.0, 1e-12));
    return clamp((normal_cdf_integral((d + w) / s) - normal_cdf_integral((d - w) / s)) * s / (2.0 * w), 0.0, 1.0);
  }
  float a = abs(d);
  float tail = (wide + narrow - a) * (wide + narrow - a) / max(8.0 * wide * narrow, 1e-30);
  float middle = 0.5 - 0.5 * a / max(wide, 1e-15);
  tail = a <= wide - narrow ? middle : a < wide + narrow ? tail : 0.0;
  return d > 0.0 ? 1.0 - tail : tail;
}

// What the variance of the blur has more at u than in the middle of the projector's image, px^2.
float more_blur(vec2 u) {
  vec4 edge = params.projector_edge, b = params.blur_field;
  vec2 at = (2.0 * u - (edge.xz + edge.yw)) / (edge.yw - edge.xz);
  float more = b.x * at.x + b.y * at.y + b.z * at.x * at.x + b.w * at.x * at.y + params.blur_field_rest.x * at.y * at.y;
  return max(more, params.blur_field_rest.y);
}
// Sigma of the blur of images that are evaluated directly, px of the projector; set by set_blur().
float blur_px = 0.0;
void set_blur(vec2 u) { blur_px = BLUR_FIELD != 0 ? sqrt(params.light.z * params.light.z + more_blur(u)) : params.light.z; }
// The same along an axis, with that of light that has been inside.
float blur_along(vec2 axis) {
  return SUBSURFACE != 0 ? sqrt(blur_px * blur_px + below_variance * below_spread_px2(axis)) : blur_px;
}

// Mean of a Gray image over the footprint; x in code words.
float gray_value(real x, vec2 axis, float words_per_px, vec4 b) {
  float m = float(dot(axis, footprint_middle)) * words_per_px;
  float hx = abs(dot(axis, footprint_x)) * words_per_px, hy = abs(dot(axis, footprint_y)) * words_per_px;
  float most = MOST_FOOTPRINT_WORDS / max(hx + hy, MOST_FOOTPRINT_WORDS);
  float wide = max(hx, hy) * most, narrow = min(hx, hy) * most, sigma = blur_along(axis) * words_per_px;
  real start = floor(x);
  float middle = float(x - start) + m, reach = wide + narrow + (GRAY_BLUR != 0 ? 5.5 * sigma : 0.0);
  int base = int(start), last = int(floor(middle + reach));
  float sum = 0.0, before = 0.0;
  for (int j = int(floor(middle - reach)); j <= last; ++j) {
    float share = j < last ? share_left(float(j + 1) - middle, wide, narrow, sigma) : 1.0;
    int k = (base + j) & int(b.y);  // the code repeats beyond its last word
    sum += (share - before) * ((((k ^ (k >> 1)) >> int(b.x)) & 1) != 0 ? b.w : b.z);
    before = share;
  }
  return sum;
}

// Mean of a projected image over the footprint, each axis for itself: exact where the camera's rows run
// along the projector's, else each pixel's corners are a little rounded. Border pixels continue.
float image_value(vec2 u, vec4 b) {
  vec2 middle = u - params.projector_edge.xz + footprint_middle;  // from the raster's corner, px
  vec2 fx = abs(footprint_x), fy = abs(footprint_y), sum_f = max(fx + fy, MOST_FOOTPRINT_PX);
  vec2 wide = max(fx, fy) * (MOST_FOOTPRINT_PX / sum_f), narrow = min(fx, fy) * (MOST_FOOTPRINT_PX / sum_f);
  float sigma = blur_px;
  vec2 reach = wide + narrow + (GRAY_BLUR != 0 ? 5.5 * sigma : 0.0);
  ivec2 start = ivec2(floor(middle - reach)), last = ivec2(floor(middle + reach)), size = ivec2(b.yz);
  float sum = 0.0, before_y = 0.0;
  for (int y = start.y; y <= last.y; ++y) {
    float share_y = y < last.y ? share_left(float(y + 1) - middle.y, wide.y, narrow.y, sigma) : 1.0;
    int row = int(b.x) + clamp(y, 0, size.y - 1) * size.x;
    float row_sum = 0.0, before_x = 0.0;
    for (int x = start.x; x <= last.x; ++x) {
      float share_x = x < last.x ? share_left(float(x + 1) - middle.x, wide.x, narrow.x, sigma) : 1.0;
      row_sum += (share_x - before_x) * texelFetch(waveforms, row + clamp(x, 0, size.x - 1)).x;
      before_x = share_x;
    }
    sum += (share_y - before_y) * row_sum;
    before_y = share_y;
  }
  return sum;
}

// Fourier transform 2 J1(x)/x of a uniform disk; Abramowitz and Stegun 9.4.4 and 9.4.6 (4e-8).
float disk_attenuation(float x) {
  float t = min(x, 3.0) / 3.0, s = t * t, q = 3.0 / max(x, 3.0);
  float near = 1.0 + s * (-1.12499970 + s * (0.42187146 + s * (-0.07908578 +
               s * (0.00886638 + s * (-0.00063522 + s * 0.00002218)))));
  float f = 0.79788456 + q * (0.00000156 + q * (0.01659667 + q * (0.00017105 + q * (-0.00249511 +
            q * (0.00113653 - q * 0.00020033)))));
  float angle = x - 2.35619449 + q * (0.12499612 + q * (0.00005650 + q * (-0.00637879 + q * (0.00074348 +
                q * (0.00079824 - q * 0.00029166)))));
  return x <= 3.0 ? near : 2.0 * f * cos(angle) / (x * sqrt(x));
}

// Share of a disk of radius 1 left of t.
float disk_share(float t) {
  t = clamp(t, -1.0, 1.0);
  return 0.5 + (t * sqrt(1.0 - t * t) + asin(t)) * (1.0 / PI);
}

float table_value(int i, vec4 b, real x) {
  if (i < N_PERIODIC) return waveform(int(b.x), float(x - floor(x)) * b.y);  // x in turns
  return waveform(int(b.x), clamp(float(x), 0.0, b.y));
}

// Cell k of an image that is constant on unit cells: a pixel of the frame buffer or a code word. The
// code repeats beyond its last word.
float cell_value(int i, vec4 b, int k) {
  if (i < N_TABLES + N_PIXEL) return texelFetch(waveforms, int(b.x) + clamp(k, 0, int(b.y))).x;
  k &= int(b.y);
  return (((k ^ (k >> 1)) >> int(b.x)) & 1) != 0 ? b.w : b.z;
}

// Mean of a table over a normal distribution, by the trapezoid rule; x and sigma in turns or samples.
float mean_of_table(int i, vec4 b, real x, float sigma) {
  const float REACH = 5.0;  // standard deviations
  int n = 12 + int(min(ceil(b.z * REACH * sigma), 250.0));
  float sum = 0.0, shares = 0.0;
  for (int k = -n; k <= n; ++k) {
    float at = REACH * float(k) / float(n), share = exp(-0.5 * at * at);
    sum += share * table_value(i, b, x + real(at * sigma));
    shares += share;
  }
  return sum / shares;
}

float direct_value(int i, real2 u) {
  real4 a = REAL_PARAM(direct[i]);
  vec4 b = params.direct_b[i];
  real x = dot(a.zw, u) * a.x + a.y;
  if (DEFOCUS == 0) {
    if (SUBSURFACE != 0 && i < N_TABLES)
      return mean_of_table(i, b, x, float(a.x) * sqrt(below_variance * below_spread_px2(vec2(a.zw))));
    if (i < N_TABLES) return table_value(i, b, x);
    if (i < N_TABLES + N_PIXEL) return cell_value(i, b, int(floor(x)));
    if (i < FIRST_IMAGE) return gray_value(x, vec2(a.zw), float(a.x), b);
    return image_value(vec2(u), b);
  }
  float r = defocus * float(dot(a.zw, REAL_PARAM(projector_f).xy) * a.x);
  float sum = 0.0;
  if (i < N_TABLES) {
    // The disk's projection on the axis has the density sqrt(1 - t^2): Gauss-Chebyshev, second kind.
    int n = 8 + int(min(ceil(b.z * r), 500.0));
    for (int j = 1; j <= n; ++j) {
      float angle = PI * float(j) / float(n + 1), s = sin(angle);
      sum += s * s * table_value(i, b, x + real(r * cos(angle)));
    }
    return sum * 2.0 / float(n + 1);
  }
  r = clamp(r, 1e-6, 500.0);
  int base = int(floor(x));
  float part = float(x - floor(x)), below = 0.0;
  for (int k = int(floor(part - r)); k <= int(floor(part + r)); ++k) {
    float share = disk_share((float(k + 1) - part) / r);
    sum += cell_value(i, b, base + k) * (share - below);
    below = share;
  }
  return sum;
}

// The same in light of which a share has been inside.
float direct_value_from_below(int i, real2 u) {
  vec2 axis = params.direct[i].zw;
  real2 entered = u + real2(axis * entered_beside_px(axis));
  float sum = 0.0;
  for (int k = 0; k < BELOW_NORMALS; ++k) {
    below_variance = BELOW_VARIANCE[k] * below.scale * below.scale;
    sum += BELOW_SHARE[k] * direct_value(i, entered);
  }
  below_variance = 0.0;
  return mix(direct_value(i, u), sum, below.share);
}

float pitch_contrast(int i) {
  vec4 pitch = params.pitch[i];
  return disk_attenuation(TWO_PI * defocus * dot(pitch.zw, params.projector_f.xy) * pitch.x);
}

// What is left of a pair over what a direction stands for, taken as normal.
float spread_attenuation(int i) {
  vec4 pitch = params.pitch[i];
  return exp(-0.5 * TWO_PI * TWO_PI * pitch.x * pitch.x * dot(pitch.zw, spread_px2));
}

void add_patterns(float w, real2 u, inout float cosine[MAX_PITCHES], inout float sine[MAX_PITCHES],
                  inout float direct[MAX_DIRECT]) {
  float c1 = 1.0, s1 = 0.0, c = 1.0, s = 0.0;  // of the pitch; of the pair
  float more = 0.0;
  if (BLUR_FIELD != 0) more = -0.5 * TWO_PI * TWO_PI * more_blur(vec2(u));
  if (N_GRAY + N_IMAGES > 0) set_blur(vec2(u));
  if (DEFOCUS != 0 && w == 0.0) defocus = 0.0;
#define ADD_PITCH(i)                                                            \
  if (i < N_PITCHES) {                                                          \
    if ((FUNDAMENTALS & (1 << i)) != 0) {                                       \
      real4 pitch = REAL_PARAM(pitch[i]);                                       \
      real turns = dot(pitch.zw, u) * pitch.x + pitch.y;                        \
      float theta = TWO_PI * float(turns - floor(turns + 0.5)); /* [-pi, pi) */ \
      c = c1 = cos(theta);                                                      \
      s = s1 = sin(theta);                                                      \
    } else {                                                                    \
      float next = c * c1 - s * s1;                                             \
      s = s * c1 + c * s1;                                                      \
      c = next;                                                                 \
    }                                                                           \
    float v = w;                                                                \
    if (DEFOCUS != 0) v *= pitch_contrast(i);                                   \
    if (BLUR_FIELD != 0) v *= exp(more * params.pitch[i].x * params.pitch[i].x); \
    if (BOUNCES != 0) v *= spread_attenuation(i);                               \
    vec2 left = SUBSURFACE != 0 ? pair_from_below(i) : vec2(1.0, 0.0);         \
    cosine[i] += SUBSURFACE != 0 ? v * (c * left.x - s * left.y) : v * c;       \
    sine[i] += SUBSURFACE != 0 ? v * (s * left.x + c * left.y) : v * s;         \
  }
#define ADD_DIRECT(i) \
  if (i < N_DIRECT) direct[i] += w * (SUBSURFACE != 0 ? direct_value_from_below(i, u) : direct_value(i, u));
  REPEAT32(ADD_PITCH)
  REPEAT16(ADD_DIRECT)
}

void load_sums(bool resume, uint slot, uint stride, out float mean, out float hits, out float cosine[MAX_PITCHES],
               out float sine[MAX_PITCHES], out float direct[MAX_DIRECT]) {
  mean = resume ? sums[slot] : 0.0;
  hits = resume ? sums[slot + stride] : 0.0;
#define LOAD_PITCH(i)                                                     \
  if (i < N_PITCHES) {                                                    \
    cosine[i] = resume ? sums[slot + (2 + 2 * i) * stride] : 0.0;         \
    sine[i] = resume ? sums[slot + (3 + 2 * i) * stride] : 0.0;           \
  }
#define LOAD_DIRECT(i) \
  if (i < N_DIRECT) direct[i] = resume ? sums[slot + (2 + 2 * N_PITCHES + i) * stride] : 0.0;
  REPEAT32(LOAD_PITCH)
  REPEAT16(LOAD_DIRECT)
}

void store_sums(uint slot, uint stride, float mean, float hits, float cosine[MAX_PITCHES], float sine[MAX_PITCHES],
                float direct[MAX_DIRECT]) {
  sums[slot] = mean;
  sums[slot + stride] = hits;
#define STORE_PITCH(i)                             \
  if (i < N_PITCHES) {                             \
    sums[slot + (2 + 2 * i) * stride] = cosine[i]; \
    sums[slot + (3 + 2 * i) * stride] = sine[i];   \
  }
#define STORE_DIRECT(i) \
  if (i < N_DIRECT) sums[slot + (2 + 2 * N_PITCHES + i) * stride] = direct[i];
  REPEAT32(STORE_PITCH)
  REPEAT16(STORE_DIRECT)
}
