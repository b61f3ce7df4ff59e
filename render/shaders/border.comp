#version 460
// SPDX-License-Identifier: Apache-2.0
// Does an edge cross the pixel's own square, or only its neighbourhood? Eight rays along the square's border
// against the one through its centre: a straight edge that crosses a square parts its corners.
// objects: BORDER_ (shared.h).
#extension GL_GOOGLE_include_directive : require
#include "ray.glsl"
#include "patterns.glsl"
#include "shade.glsl"
#include "work_items.glsl"
#include "identity.glsl"
#include "look.glsl"

layout(local_size_x = BLOCK_WIDTH, local_size_y = BLOCK_HEIGHT) in;

void main() {
  load_constants();
  uint slot = own_slot();
  ivec2 pixel = ivec2(listed_pixel(slot).xy);
  start_walks(uvec2(pixel.xy));
  PixelRays rays = pixel_rays(vec2(pixel));
  vec4 c = probe_at(pixel);
  Seen centre = Seen(c.z, c.w, real2(c.xy), NEVER_BELOW);
  bool mesh = N_MESHES > 0 && c.w > 0.0 && primitive_of(c.w) >= FIRST_MESH;
  bool crossed = false;
  float swing = 0.0;
  uint shadow_rays = 0;
  for (int i = 0; i < (beyond_list(slot) ? 0 : 8); ++i) {
    int k = i < 4 ? i : i + 1;
    vec2 offset = 0.5 * params.sampling.x * vec2(k % 3 - 1, k / 3 - 1);
    Seen seen = look(rays, offset, shadow_rays);
    crossed = crossed || !same_surface(centre, seen);
    swing = max(swing, seen.w > 0.0 && c.w > 0.0 ? length(vec2(seen.u - centre.u)) : 0.0);
  }
  // Several fringes in the pixel ask for scan lines as an edge does.
  swing *= 2.0 * finest_swing();
  bool dense = swing > (mesh ? MOST_FACET_SWING : 4.0);
  objects[slot] = crossed ? BORDER_CROSSED : dense ? BORDER_DENSE : mesh ? BORDER_FACETS : BORDER_SMOOTH;
  report_status(uvec2(pixel), shadow_rays);
}
