// SPDX-License-Identifier: Apache-2.0
// What part of the projector's image a sample of a Gauss rule stands for. Images with sharp edges need it:
// at n x n points their mean over a pixel would take n + 1 values only.

// Differentials of the ray (Igehy, "Tracing Ray Differentials", SIGGRAPH 1999) carried to the surface's
// tangent plane, from there by the projector's own formula.
vec2 projected_step(const PixelRays rays, const Sample sample_, const Hit hit, real3 p, vec3 d, real2 u, vec2 axis) {
  const float STEP = 0.25;  // px: the difference keeps three digits, the curvature in it is negligible
  real3 d0 = ray_direction(rays, sample_.offset), d1 = ray_direction(rays, sample_.offset + STEP * axis);
  if (LENS_DISK != 0) {
    d0 /= d0.z;
    d1 /= d1.z;
  }
  vec3 turn = vec3(d1 - d0);
  vec3 move = hit.t * (turn - d * (dot(hit.n_geometric, turn) / dot(hit.n_geometric, d)));
  real2 moved;
  float kept = defocus;
  project(p + real3(move), moved);
  defocus = kept;
  vec2 step_px = vec2(moved - u) / STEP;
  // At grazing points beyond the projector's horizon it may be anything.
  return max(abs(step_px.x), abs(step_px.y)) < 1e4 ? step_px : vec2(0.0);
}

void set_footprint(const PixelRays rays, const Sample sample_, const Hit hit, real3 p, vec3 d, real2 u) {
  int first = int(params.sampling_n.x) * (LENS_DISK != 0 ? 2 : 1), place = int(sample_.place);
  vec2 x = texelFetch(sample_table, first + place % MOST_COLUMNS).xy;
  vec2 y = texelFetch(sample_table, first + place / MOST_COLUMNS).xy;
  vec2 step_x = projected_step(rays, sample_, hit, p, d, u, vec2(1.0, 0.0));
  vec2 step_y = projected_step(rays, sample_, hit, p, d, u, vec2(0.0, 1.0));
  footprint_middle = 0.5 * ((x.x + x.y) * step_x + (y.x + y.y) * step_y);
  footprint_x = 0.5 * (x.y - x.x) * step_x;
  footprint_y = 0.5 * (y.y - y.x) * step_y;
}
