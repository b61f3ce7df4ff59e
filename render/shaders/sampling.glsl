// SPDX-License-Identifier: Apache-2.0
// Samples over the pixel's square and the lens disk.
//  table: Gauss-Legendre product rules made on the CPU, the same for every pixel
//  multi-jittered: Kensler, "Correlated Multi-Jittered Sampling", Pixar TM 13-01 (2013), any N
//  sobol: Owen-scrambled per pixel by the hash of Burley, "Practical Hash-based Owen Scrambling",
//  JCGT 9(4), 2020

struct Sample {
  vec2 offset;  // px from the centre
  vec2 lens;    // mm on the lens disk
  float weight;
  float place;  // in the Gauss rule: column + MOST_COLUMNS row
};

// Wellons' lowbias32.
uint hash(uint x) {
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  return x ^ (x >> 16);
}

float unit_float(uint x) { return float(x >> 8) * (1.0 / 16777216.0); }

// Kensler's permutation of 0 ... l-1 by cycle walking.
uint permute(uint i, uint l, uint p) {
  uint w = l - 1;
  w |= w >> 1;
  w |= w >> 2;
  w |= w >> 4;
  w |= w >> 8;
  w |= w >> 16;
  do {
    i ^= p;
    i *= 0xe170893du;
    i ^= p >> 16;
    i ^= (i & w) >> 4;
    i ^= p >> 8;
    i *= 0x0929eb3fu;
    i ^= p >> 23;
    i ^= (i & w) >> 1;
    i *= 1u | p >> 27;
    i *= 0x6935fa69u;
    i ^= (i & w) >> 11;
    i *= 0x74dcb303u;
    i ^= (i & w) >> 2;
    i *= 0x9e501cc3u;
    i ^= (i & w) >> 2;
    i *= 0xc860a3dfu;
    i &= w;
    i ^= i >> 5;
  } while (i >= l);
  return (i + p) % l;
}

vec2 multi_jittered(uint s, uint p) {
  uint n = params.sampling_n.x, columns = params.sampling_n.y, rows = params.sampling_n.z;
  // columns * rows == n: the rectangular form; otherwise the form for any n.
  bool any_n = SAMPLER == SAMPLER_MULTI_JITTERED_ANY;
  if (any_n) s = permute(s, n, p * 0x51633e2du);
  uint sx = permute(s % columns, columns, p * 0xa511e9b3u);
  uint sy = permute(s / columns, rows, p * 0x63d83595u);
  float jx = unit_float(hash(s ^ hash(p ^ 0xa399d265u)));
  float jy = unit_float(hash(s ^ hash(p ^ 0x711ad6a5u)));
  if (any_n) return vec2((float(sx) + (float(sy) + jx) / float(rows)) / float(columns), (float(s) + jy) / float(n));
  return vec2((float(s % columns) + (float(sy) + jx) / float(rows)) / float(columns),
              (float(s / columns) + (float(sx) + jy) / float(columns)) / float(rows));
}

uint owen_scramble(uint x, uint seed) {
  x = bitfieldReverse(x);
  x += seed;
  x ^= x * 0x6c50b47cu;
  x ^= x * 0xb82f1e52u;
  x ^= x * 0xc7afe638u;
  x ^= x * 0x8d22f6e6u;
  return bitfieldReverse(x);
}

// Shirley and Chiu's concentric map, unit square to unit disk.
vec2 to_disk(vec2 v) {
  vec2 a = 2.0 * v - 1.0;
  bool wide = abs(a.x) > abs(a.y);
  float r = wide ? a.x : a.y;
  float ratio = wide ? a.y / a.x : (a.y != 0.0 ? a.x / a.y : 0.0);
  float angle = wide ? (PI / 4.0) * ratio : PI / 2.0 - (PI / 4.0) * ratio;
  return r * vec2(cos(angle), sin(angle));
}

Sample pixel_sample(uint s, uint pixel_seed) {
  Sample r;
  r.lens = vec2(0.0);
  r.place = 0.0;
  if (SAMPLER == SAMPLER_TABLE) {
    vec4 t = texelFetch(sample_table, int(LENS_DISK != 0 ? 2 * s : s));
    r.offset = t.xy;
    r.weight = t.z;
    r.place = t.w;
    if (LENS_DISK != 0) r.lens = texelFetch(sample_table, int(2 * s + 1)).xy;
    return r;
  }
  vec2 square, lens = vec2(0.5);
  if (SAMPLER != SAMPLER_SOBOL) {
    square = multi_jittered(s, pixel_seed);
    if (LENS_DISK != 0) {
      uint p = hash(pixel_seed + 1u);
      lens = multi_jittered(permute(s, params.sampling_n.x, p ^ 0x51633e2du), p);
    }
  } else {
    uvec4 x = texelFetch(sobol_table, int(s));
    square = vec2(unit_float(owen_scramble(x.x, hash(pixel_seed + 2u))),
                  unit_float(owen_scramble(x.y, hash(pixel_seed + 3u))));
    if (LENS_DISK != 0)
      lens = vec2(unit_float(owen_scramble(x.z, hash(pixel_seed + 4u))),
                  unit_float(owen_scramble(x.w, hash(pixel_seed + 5u))));
  }
  r.offset = (square - 0.5) * params.sampling.x;
  r.weight = params.sampling.y;
  if (LENS_DISK != 0) r.lens = to_disk(lens) * params.sampling.z;
  return r;
}
