#version 460
// SPDX-License-Identifier: Apache-2.0
// What places of the surfaces get over other surfaces: the sums of docs/PHYSICS.md per unit of their own
// reflectivity, in the channel of the hits the mean over the first half of the directions; then GATHER_MORE
// channels: where the mean comes from (three components), and the share of the directions that leave the surface.
// The places are what listed pixels see (then they are written, and nothing is gathered), or are given.
#extension GL_GOOGLE_include_directive : require
#include "ray.glsl"
#include "sampling.glsl"
#include "patterns.glsl"
#include "shade.glsl"
#include "work_items.glsl"
#include "cells.glsl"
#include "bounce.glsl"

layout(local_size_x = BLOCK_WIDTH, local_size_y = BLOCK_HEIGHT) in;

// A place as the host reads it: position, shading normal, normal, each with a number.
void write_place(uint entry, const Hit hit, vec3 numbers) {
  places_out[3 * entry] = vec4(hit.p, numbers.x);
  places_out[3 * entry + 1] = vec4(hit.n, numbers.y);
  places_out[3 * entry + 2] = vec4(hit.n_geometric, numbers.z);
}

const float LEAST_COSINE = 0.1;  // light along the surface tells little of where it comes from

void main() {
  load_constants();
  uint slot = own_slot(), stride = push.n_blocks_band * BLOCK_PIXELS, shadow_rays = 0;
  uint looking = min(push.n_pixels, 1u), n = max(push.n_directions, 2u), seed = 0u;
  uvec2 pixel = uvec2(slot, 0u);
  Hit hit = no_hit();
  real2 u;
  for (uint k = 0; k < looking; ++k) {  // loops, because only a loop can be skipped
    pixel = listed_pixel(slot).xy;
    start_walks(pixel);
    PixelRays rays = pixel_rays(vec2(pixel));
    vec3 d = vec3(ray_direction(rays, params.look.xy));
    hit = closest_hit(vec3(0.0), d);
    float of_projector = hit.primitive >= 0 ? shade(hit, real3(hit.p), d, u, shadow_rays) : -1.0;
    write_place(slot, hit, vec3(of_projector, hit.material.x, float(hit.primitive)));
  }
  for (uint k = looking; k < 1; ++k) {
    vec4 place = texelFetch(gather_points, 3 * int(slot));
    hit.p = place.xyz;
    hit.n = texelFetch(gather_points, 3 * int(slot) + 1).xyz;
    hit.n_geometric = texelFetch(gather_points, 3 * int(slot) + 2).xyz;
    hit.primitive = 0;
    seed = hash(uint(place.w) + hash(params.sampling_n.w));
  }

  float mean = 0.0, first_half = 0.0;
  float cosine[MAX_PITCHES], sine[MAX_PITCHES], direct[MAX_DIRECT];
  load_sums(push.resume != 0, slot, stride, mean, first_half, cosine, sine, direct);
  vec4 more = vec4(0.0);
  uint first_more = slot + uint(2 + 2 * N_PITCHES + N_DIRECT) * stride;
  for (uint k = 0; k < push.resume * uint(GATHER_MORE); ++k) more[k] = sums[first_more + k * stride];
  vec3 t, b, o = bounce_start(hit);
  basis(hit.n, t, b);
  footprint_middle = footprint_x = footprint_y = vec2(0.0);
  for (uint k = push.first_sample; k < push.end_sample; ++k) {
    vec3 d = bounce_direction(k, n, seed, hit.n, t, b);
    Hit other = bounce_hit(o, d);
    bool leaves = dot(d, hit.n_geometric) > 0.0, arrives = leaves && other.primitive >= 0;
    float share = arrives ? 1.0 / float(n) : 0.0, before = mean;
    float w = shade(other, real3(other.p), d, u, shadow_rays) * share;
    mean += w;
    set_spread(other, d, dot(d, hit.n), n / 2u, u);
    add_patterns(w, w != 0.0 ? u : real2(0.0), cosine, sine, direct);
    if (MORE_BOUNCES != 0) add_light_of_cell(other, share * other.material.x, mean, cosine, sine, direct);
    first_half += 2u * k < n ? mean - before : 0.0;
    more += vec4(d * ((mean - before) / max(dot(d, hit.n), LEAST_COSINE)), leaves ? 1.0 / float(n) : 0.0);
    if (WRITE_PLACES != 0)
      write_place(slot * n + k, other, vec3(arrives ? other.material.x : -1.0, 0.0, 0.0));
  }
  store_sums(slot, stride, mean, first_half, cosine, sine, direct);
  for (uint k = 0; k < uint(GATHER_MORE); ++k) sums[first_more + k * stride] = more[k];
  report_status(pixel, shadow_rays);
}
