// SPDX-License-Identifier: Apache-2.0
// One ray anywhere in a pixel, and whether two rays saw the same surface.

struct Seen {
  float w, id;
  real2 u;
  Below below;
};

// No border worth finding lies between the two. Two facets of one lit mesh count as one surface unless
// shading or position jump: creases leave far less than edges, and four nodes a line average them.
bool same_surface(Seen a, Seen b) {
  if (a.id == b.id) return true;
  if (a.w == 0.0 && b.w == 0.0) return params.adaptive.z == 0.0 || (a.id != 0.0) == (b.id != 0.0);
  if (N_MESHES == 0 || a.w == 0.0 || b.w == 0.0 || a.id == 0.0 || b.id == 0.0) return false;
  vec2 step = abs(vec2(a.u - b.u));
  return primitive_of(a.id) == primitive_of(b.id) && abs(a.w - b.w) < 0.05 * max(a.w, b.w) && max(step.x, step.y) < 0.5;
}

Seen look(const PixelRays rays, vec2 offset, inout uint shadow_rays) {
  real3 d = ray_direction(rays, offset);
  Hit hit = closest_hit(vec3(0.0), vec3(d));
  Seen s;
  s.w = shade(hit, refined_point(hit, real3(0.0), d), vec3(d), s.u, shadow_rays);
  s.id = identity(hit, s.w);
  s.below = below;
  return s;
}

