#version 460
// SPDX-License-Identifier: Apache-2.0
// What points of the surfaces get over one other surface: the sums of docs/PHYSICS.md per unit of their own
// reflectivity, and what each direction met, for the cells of render/indirect/light_cells.hpp. The points are
// what the middles of listed pixels see, or places that were met before.
#extension GL_GOOGLE_include_directive : require
#include "ray.glsl"
#include "sampling.glsl"
#include "patterns.glsl"
#include "shade.glsl"
#include "work_items.glsl"
#include "cells.glsl"
#include "bounce.glsl"

layout(local_size_x = BLOCK_WIDTH, local_size_y = BLOCK_HEIGHT) in;

// A place as the host reads it: position and `number`, shading normal, normal.
void write_place(uint entry, const Hit hit, float number) {
  hits_out[3 * entry] = vec4(hit.p, number);
  hits_out[3 * entry + 1] = vec4(hit.n, 0.0);
  hits_out[3 * entry + 2] = vec4(hit.n_geometric, 0.0);
}

void main() {
  load_constants();
  uint slot = own_slot(), stride = push.n_blocks_band * BLOCK_PIXELS;
  uvec2 pixel = uvec2(slot, 0u);
  uint seed = 0u, camera_rays = min(push.n_pixels, 1u), shadow_rays = 0;
  Hit hit = no_hit();
  real2 u;
  float of_projector = -1.0;
  for (uint k = 0; k < camera_rays; ++k) {  // loops, because only a loop can be skipped
    pixel = listed_pixel(slot).xy;
    start_walks(pixel);
    PixelRays rays = pixel_rays(vec2(pixel));
    vec3 d = vec3(ray_direction(rays, vec2(0.0)));
    hit = closest_hit(vec3(0.0), d);
    of_projector = hit.primitive >= 0 ? shade(hit, real3(hit.p), d, u, shadow_rays) : -1.0;
    seed = hash(pixel.x + hash(pixel.y));
  }
  for (uint k = camera_rays; k < 1; ++k) {
    vec4 place = texelFetch(gather_points, 3 * int(slot));
    hit.p = place.xyz;
    hit.n = texelFetch(gather_points, 3 * int(slot) + 1).xyz;
    hit.n_geometric = texelFetch(gather_points, 3 * int(slot) + 2).xyz;
    hit.primitive = 0;
    seed = uint(place.w);
  }
  vec2 shift = bounce_shift(hash(seed + hash(params.sampling_n.w)));

  float mean = 0.0, hits = 0.0;
  float cosine[MAX_PITCHES], sine[MAX_PITCHES], direct[MAX_DIRECT];
  load_sums(push.resume != 0, slot, stride, mean, hits, cosine, sine, direct);
  vec3 t, b, o = bounce_start(hit);
  basis(hit.n, t, b);
  footprint_middle = footprint_x = footprint_y = vec2(0.0);
  uint places = uint(BOUNCES) + 1u;
  write_place(slot * places, hit, of_projector);
  uint end = hit.primitive >= 0 ? push.end_sample : push.first_sample;
  for (uint k = push.first_sample; k < end; ++k) {
    vec3 d = bounce_direction(k, shift, hit.n, t, b);
    Hit other = bounce_hit(o, d);
    bool arrives = dot(d, hit.n_geometric) > 0.0;
    float w = shade(other, real3(other.p), d, u, shadow_rays) / float(max(BOUNCES, 1));
    w = arrives ? w : 0.0;
    mean += w;
    add_patterns(w, w != 0.0 ? u : real2(0.0), cosine, sine, direct);
    write_place(slot * places + 1u + k, other, arrives && other.primitive >= 0 ? other.material.x : -1.0);
  }
  store_sums(slot, stride, mean, hits, cosine, sine, direct);
  report_status(pixel, shadow_rays);
}
