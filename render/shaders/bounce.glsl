// SPDX-License-Identifier: Apache-2.0
// Directions from a place of a surface: two Hammersley sets one after the other, each shifted at random, whose
// difference tells the noise. Over the hemisphere with the density of the cosine each of n carries 1/n of the
// radiance seen along it.

// Point k of n in a unit square; n is even.
vec2 bounce_point(uint k, uint n, uint seed) {
  uint half_n = n / 2u, set = k < half_n ? 0u : 1u, i = k - set * half_n;
  uint of_set = hash(seed + set);
  vec2 shift = vec2(unit_float(of_set), unit_float(hash(of_set + 0x9e3779b9u)));
  return fract(vec2((float(i) + 0.5) / float(half_n), unit_float(bitfieldReverse(i))) + shift);
}

// The direction of a point of the square, around the normal beside t and b.
vec3 by_cosine(vec2 v, vec3 normal, vec3 t, vec3 b) {
  float r = sqrt(v.x), angle = TWO_PI * v.y;
  return (r * cos(angle)) * t + (r * sin(angle)) * b + sqrt(1.0 - v.x) * normal;
}

// Where rays that leave a hit begin: beside its surface, by more than rounding.
vec3 bounce_start(const Hit hit) {
  return hit.p + hit.n_geometric * (params.light.y * max(max(abs(hit.p.x), abs(hit.p.y)), abs(hit.p.z)));
}

// Sets what part of the projector's image a direction stands for that met a surface, one of a set that stands
// for so many steradians: a square of them. Fringes that are finer there are averaged out; point by
// point they would leave noise like that of random phases.
void set_spread(const Hit other, vec3 d, float steradian, real2 u) {
  const float LEAST = 0.05, STEP = 0.1;
  float half_side = 0.5 * other.t * sqrt(steradian);
  float slope = max(abs(dot(d, other.n_geometric)), LEAST);
  vec3 across = cross(d, other.n_geometric);
  float across_sq = dot(across, across);
  vec3 t, b;
  basis(other.n_geometric, t, b);
  across = across_sq > 1e-6 ? across / sqrt(across_sq) : t;
  vec3 along = cross(other.n_geometric, across);
  real2 moved_across, moved_along;
  float kept = defocus;
  project(real3(other.p + (STEP * half_side) * across), moved_across);
  project(real3(other.p + (STEP * half_side / slope) * along), moved_along);
  defocus = kept;
  vec2 x = vec2(moved_across - u) / STEP, y = vec2(moved_along - u) / STEP;
  footprint_x = max(abs(x.x), abs(x.y)) < 1e4 ? x : vec2(0.0);
  footprint_y = max(abs(y.x), abs(y.y)) < 1e4 ? y : vec2(0.0);
  spread_px2 = (footprint_x * footprint_x + footprint_y * footprint_y) / 3.0;
}

// What a ray from a surface meets. Unless asked, it reflects by Lambert's law alone, its lobe is left out.
Hit bounce_hit(vec3 o, vec3 d) {
  ray_from_camera = false;
  Hit other = closest_hit(o, d);
  ray_from_camera = true;
  if (GLOSSY == 0) other.material.y = 0.0;
  return other;
}
