// SPDX-License-Identifier: Apache-2.0
// What the sums collect: w cos, w sin per pitch; w * value per directly evaluated image.
// Output channels: mean, hit fraction, (cosine, sine) per pitch, direct images.

const float MOST_FOOTPRINT_WORDS = 32.0;  // wider footprints (grazing, or far too fine a code) count as that
const float MOST_FOOTPRINT_PX = 16.0;     // of an image

float waveform(int first, float position) {
  float base = floor(position);
  int i = first + int(base);
  return mix(texelFetch(waveforms, i).x, texelFetch(waveforms, i + 1).x, position - base);
}

// The sample's share of the pixel, projected (px of the projector): its middle as seen from the sample and
// two half sides. All 0: a point. Set by footprint.glsl.
vec2 footprint_middle = vec2(0.0), footprint_x = vec2(0.0), footprint_y = vec2(0.0);

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

// Mean of a Gray image over the footprint; x in code words.
float gray_value(real x, vec2 axis, float words_per_px, vec4 b) {
  float m = float(dot(axis, footprint_middle)) * words_per_px;
  float hx = abs(dot(axis, footprint_x)) * words_per_px, hy = abs(dot(axis, footprint_y)) * words_per_px;
  float most = MOST_FOOTPRINT_WORDS / max(hx + hy, MOST_FOOTPRINT_WORDS);
  float wide = max(hx, hy) * most, narrow = min(hx, hy) * most, sigma = params.light.z * words_per_px;
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
  float sigma = params.light.z;
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

float direct_value(int i, real2 u) {
  real4 a = REAL_PARAM(direct[i]);
  vec4 b = params.direct_b[i];
  real x = dot(a.zw, u) * a.x + a.y;
  if (i < N_PERIODIC) return waveform(int(b.x), float(x - floor(x)) * b.y);  // x in turns
  if (i < N_PERIODIC + N_AXIS) return waveform(int(b.x), clamp(float(x), 0.0, b.y));
  if (i < N_PERIODIC + N_AXIS + N_GRAY) return gray_value(x, vec2(a.zw), float(a.x), b);
  return image_value(vec2(u), b);
}

void add_patterns(float w, real2 u, inout float cosine[MAX_PITCHES], inout float sine[MAX_PITCHES],
                  inout float direct[MAX_DIRECT]) {
#define ADD_PITCH(i)                                                      \
  if (i < N_PITCHES) {                                                    \
    real4 pitch = REAL_PARAM(pitch[i]);                                   \
    real turns = dot(pitch.zw, u) * pitch.x + pitch.y;                    \
    float theta = TWO_PI * float(turns - floor(turns + 0.5)); /* [-pi, pi) */ \
    cosine[i] += w * cos(theta);                                          \
    sine[i] += w * sin(theta);                                            \
  }
#define ADD_DIRECT(i) \
  if (i < N_DIRECT) direct[i] += w * direct_value(i, u);
  REPEAT8(ADD_PITCH)
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
  REPEAT8(LOAD_PITCH)
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
  REPEAT8(STORE_PITCH)
  REPEAT16(STORE_DIRECT)
}
