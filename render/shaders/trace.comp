#version 460
// SPDX-License-Identifier: Apache-2.0
// One camera: per pixel the transport sums of docs/PHYSICS.md over the pixel's square (and the lens disk).
// One invocation = one pixel; a work group = one block of the list of blocks that can see something.
// On lavapipe `if` masks lanes but skips no work, only loops end early: hence specialization
// constants for every switch.
#extension GL_GOOGLE_include_directive : require
#include "ray.glsl"
#include "sampling.glsl"
#include "patterns.glsl"
#include "shade.glsl"
#include "footprint.glsl"
#include "work_items.glsl"

layout(local_size_x = BLOCK_WIDTH, local_size_y = BLOCK_HEIGHT) in;

void main() {
  load_constants();
  uint slot = own_slot(), stride = push.n_blocks_band * BLOCK_PIXELS;
  uvec2 pixel = PIXEL_LIST != 0 ? listed_pixel(slot).xy : block_pixel();

  start_walks(uvec2(pixel.xy));
  PixelRays rays = pixel_rays(vec2(pixel));
  uint pixel_seed = hash(pixel.x + hash(pixel.y + hash(params.sampling_n.w)));

  float mean = 0.0, hits = 0.0;
  float cosine[MAX_PITCHES], sine[MAX_PITCHES], direct[MAX_DIRECT];
  load_sums(push.resume != 0, slot, stride, mean, hits, cosine, sine, direct);

  // A loop, because only a loop can be skipped.
  for (uint k = 0; k < push.n_centre; ++k)
    objects[slot] = closest_hit(vec3(0.0), vec3(ray_direction(rays, vec2(0.0)))).primitive;

  uint shadow_rays = 0;
  uint end_sample = beyond_list(slot) ? 0u : push.end_sample;
  for (uint s = push.first_sample; s < end_sample; ++s) {
    Sample sample_ = pixel_sample(s, pixel_seed);
    real3 o = real3(0.0);
    real3 d = ray_direction(rays, sample_.offset);
    if (LENS_DISK != 0) {
      o = real3(sample_.lens, 0.0);
      d = d / d.z - o * REAL_PARAM(sampling).w;
    }
    Hit hit = closest_hit(vec3(o), vec3(d));
    real2 u;
    real3 p = refined_point(hit, o, d);
    float w = shade(hit, p, vec3(d), u, shadow_rays) * sample_.weight;
    if (N_GRAY + N_IMAGES > 0 && SAMPLER == SAMPLER_TABLE) set_footprint(rays, sample_, hit, p, vec3(d), u);
    mean += w;
    float seen = hit.primitive >= 0 ? sample_.weight : 0.0;
    if (LAMP != 0) seen *= room_light(hit, shadow_rays);  // a sum of light, not of hits
    hits += seen;
    add_patterns(w, w != 0.0 ? u : real2(0.0), cosine, sine, direct);
  }
  store_sums(slot, stride, mean, hits, cosine, sine, direct);

  report_status(pixel, shadow_rays);
}
