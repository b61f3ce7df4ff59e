// SPDX-License-Identifier: Apache-2.0
// Light that reaches a hit over one other, diffuse surface: BOUNCES directions with the density of the
// cosine, so that each carries diffuse/BOUNCES of the radiance seen along it. A Hammersley set, shifted
// at random per pixel and sample.

// Orthonormal basis: Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
void basis(vec3 n, out vec3 t, out vec3 b) {
  float s = n.z >= 0.0 ? 1.0 : -1.0, a = -1.0 / (s + n.z), c = n.x * n.y * a;
  t = vec3(1.0 + s * n.x * n.x * a, s * c, -s * n.x);
  b = vec3(c, s + n.y * n.y * a, -n.y);
}

void add_bounces(const Hit hit, float weight, uint sample_seed, inout float mean, inout float cosine[MAX_PITCHES],
                 inout float sine[MAX_PITCHES], inout float direct[MAX_DIRECT], inout uint shadow_rays) {
  vec3 t, b;
  basis(hit.n, t, b);
  vec3 o = hit.p + hit.n_geometric * (params.light.y * max(max(abs(hit.p.x), abs(hit.p.y)), abs(hit.p.z)));
  vec2 shift = vec2(unit_float(hash(sample_seed)), unit_float(hash(sample_seed + 0x9e3779b9u)));
  float share = weight * hit.material.x / float(max(BOUNCES, 1));
  uint n = hit.primitive >= 0 && share > 0.0 ? uint(BOUNCES) : 0u;
  footprint_middle = footprint_x = footprint_y = vec2(0.0);
  for (uint k = 0; k < n; ++k) {
    vec2 v = fract(vec2((float(k) + 0.5) / float(BOUNCES), unit_float(bitfieldReverse(k))) + shift);
    float r = sqrt(v.x), angle = TWO_PI * v.y;
    vec3 d = (r * cos(angle)) * t + (r * sin(angle)) * b + sqrt(1.0 - v.x) * hit.n;
    ray_from_camera = false;
    Hit other = closest_hit(o, d);
    ray_from_camera = true;
    other.material.y = 0.0;  // its lobe is left out
    real2 u;
    float w = shade(other, real3(other.p), d, u, shadow_rays) * share;
    w = dot(d, hit.n_geometric) > 0.0 ? w : 0.0;
    mean += w;
    add_patterns(w, w != 0.0 ? u : real2(0.0), cosine, sine, direct);
  }
}
