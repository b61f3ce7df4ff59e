// SPDX-License-Identifier: Apache-2.0
// Directions from a place of a diffuse surface over the hemisphere with the density of the cosine, so that each
// of n carries 1/n of the radiance seen along it: two Hammersley sets one after the other, each shifted at
// random, whose difference tells the noise.

// Orthonormal basis: Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
void basis(vec3 n, out vec3 t, out vec3 b) {
  float s = n.z >= 0.0 ? 1.0 : -1.0, a = -1.0 / (s + n.z), c = n.x * n.y * a;
  t = vec3(1.0 + s * n.x * n.x * a, s * c, -s * n.x);
  b = vec3(c, s + n.y * n.y * a, -n.y);
}

// Direction k of n; n is even.
vec3 bounce_direction(uint k, uint n, uint seed, vec3 normal, vec3 t, vec3 b) {
  uint half_n = n / 2u, set = k < half_n ? 0u : 1u, i = k - set * half_n;
  uint of_set = hash(seed + set);
  vec2 shift = vec2(unit_float(of_set), unit_float(hash(of_set + 0x9e3779b9u)));
  vec2 v = fract(vec2((float(i) + 0.5) / float(half_n), unit_float(bitfieldReverse(i))) + shift);
  float r = sqrt(v.x), angle = TWO_PI * v.y;
  return (r * cos(angle)) * t + (r * sin(angle)) * b + sqrt(1.0 - v.x) * normal;
}

// Where rays that leave a hit begin: beside its surface, by more than rounding.
vec3 bounce_start(const Hit hit) {
  return hit.p + hit.n_geometric * (params.light.y * max(max(abs(hit.p.x), abs(hit.p.y)), abs(hit.p.z)));
}

// What a ray from a surface meets; it reflects by Lambert's law alone, its lobe is left out.
Hit bounce_hit(vec3 o, vec3 d) {
  ray_from_camera = false;
  Hit other = closest_hit(o, d);
  ray_from_camera = true;
  other.material.y = 0.0;
  return other;
}
