// SPDX-License-Identifier: Apache-2.0
// What the sums collect: w cos, w sin per pitch; w * value per directly evaluated image.
// Output channels: mean, hit fraction, (cosine, sine) per pitch, direct images.

float waveform(int first, float position) {
  float base = floor(position);
  int i = first + int(base);
  return mix(texelFetch(waveforms, i).x, texelFetch(waveforms, i + 1).x, position - base);
}

float direct_value(int i, real2 u) {
  real4 a = REAL_PARAM(direct[i]);
  vec4 b = params.direct_b[i];
  real x = dot(a.zw, u) * a.x + a.y;
  if (i < N_PERIODIC) return waveform(int(b.x), float(x - floor(x)) * b.y);  // x in turns
  if (i < N_PERIODIC + N_AXIS) return waveform(int(b.x), clamp(float(x), 0.0, b.y));
  int k = int(floor(x)) & int(b.y);  // x in code words; the code repeats beyond its last word
  return (((k ^ (k >> 1)) >> int(b.x)) & 1) != 0 ? b.w : b.z;
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
