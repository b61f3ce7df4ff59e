#version 460
// SPDX-License-Identifier: Apache-2.0
// One ray through every pixel's centre: where it falls in the projector's image, its weight, and which
// surface it saw. The adaptive trace decides from these what each pixel needs.
#extension GL_GOOGLE_include_directive : require
#include "ray.glsl"
#include "subsurface.glsl"
#include "shade.glsl"
#include "work_items.glsl"
#include "identity.glsl"

layout(local_size_x = BLOCK_WIDTH, local_size_y = BLOCK_HEIGHT) in;

void main() {
  load_constants();
  uvec2 pixel = block_pixel();
  start_walks(pixel);
  real3 d = ray_direction(pixel_rays(vec2(pixel)), vec2(0.0));
  Hit hit = closest_hit(vec3(0.0), vec3(d));
  real2 u;
  uint shadow_rays = 0;
  float w = shade(hit, refined_point(hit, real3(0.0), d), vec3(d), u, shadow_rays);
  if (in_image(ivec2(pixel))) {
    uint at = pixel.y * params.image.x + pixel.x;
    probe_out[at] = vec4(w > 0.0 ? vec2(u) : vec2(0.0), w, identity(hit, w));
    if (SUBSURFACE != 0) {
      at = params.image.x * params.image.y + PROBE_MORE * at;
      PACK_BELOW(probe_out, at)
    }
  }
  report_status(pixel, shadow_rays);
}
