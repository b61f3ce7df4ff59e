// SPDX-License-Identifier: Apache-2.0
// Light that reaches a hit over one other, diffuse surface, and with MORE_BOUNCES over others before it:
// BOUNCES directions with the density of the cosine, so that each carries diffuse/BOUNCES of the radiance
// seen along it. A Hammersley set, shifted at random per pixel and sample.

// Orthonormal basis: Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
void basis(vec3 n, out vec3 t, out vec3 b) {
  float s = n.z >= 0.0 ? 1.0 : -1.0, a = -1.0 / (s + n.z), c = n.x * n.y * a;
  t = vec3(1.0 + s * n.x * n.x * a, s * c, -s * n.x);
  b = vec3(c, s + n.y * n.y * a, -n.y);
}

vec2 bounce_shift(uint seed) {
  return vec2(unit_float(hash(seed)), unit_float(hash(seed + 0x9e3779b9u)));
}

vec3 bounce_direction(uint k, vec2 shift, vec3 n, vec3 t, vec3 b) {
  vec2 v = fract(vec2((float(k) + 0.5) / float(BOUNCES), unit_float(bitfieldReverse(k))) + shift);
  float r = sqrt(v.x), angle = TWO_PI * v.y;
  return (r * cos(angle)) * t + (r * sin(angle)) * b + sqrt(1.0 - v.x) * n;
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

void add_bounces(const Hit hit, float weight, uint sample_seed, inout float mean, inout float cosine[MAX_PITCHES],
                 inout float sine[MAX_PITCHES], inout float direct[MAX_DIRECT], inout uint shadow_rays) {
  vec3 t, b;
  basis(hit.n, t, b);
  vec3 o = bounce_start(hit);
  vec2 shift = bounce_shift(sample_seed);
  float share = weight * hit.material.x / float(max(BOUNCES, 1));
  uint n = hit.primitive >= 0 && share > 0.0 ? uint(BOUNCES) : 0u;
  footprint_middle = footprint_x = footprint_y = vec2(0.0);
  for (uint k = 0; k < n; ++k) {
    vec3 d = bounce_direction(k, shift, hit.n, t, b);
    Hit other = bounce_hit(o, d);
    real2 u;
    float arrives = dot(d, hit.n_geometric) > 0.0 ? share : 0.0;
    float w = shade(other, real3(other.p), d, u, shadow_rays) * arrives;
    mean += w;
    add_patterns(w, w != 0.0 ? u : real2(0.0), cosine, sine, direct);
    if (MORE_BOUNCES != 0)
      add_light_of_cell(other, arrives * other.material.x, mean, cosine, sine, direct);
  }
}
