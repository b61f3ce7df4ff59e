#version 460
// SPDX-License-Identifier: Apache-2.0
// What places of the surfaces get over other surfaces: the sums of docs/PHYSICS.md per unit of their own
// reflectivity, in the channel of the hits the mean over the first half of the directions; then GATHER_MORE
// channels: where the mean comes from (three components), the share of the directions that leave the surface, and
// of glossy light the finest fringes over the first half (cosine, sine).
// The places are what listed pixels see (then they are written, and nothing is gathered), or are given. With
// BY_LOBE it is what their lobes send to the camera of the light around them.
#extension GL_GOOGLE_include_directive : require
#include "ray.glsl"
#include "sampling.glsl"
#include "patterns.glsl"
#include "shade.glsl"
#include "work_items.glsl"
#include "cells.glsl"
#include "bounce.glsl"
#include "lobe.glsl"
#include "mirror_way.glsl"

layout(local_size_x = BLOCK_WIDTH, local_size_y = BLOCK_HEIGHT) in;

// A place as the host reads it: position, shading normal, normal, each with a number.
void write_place(uint entry, const Hit hit, vec3 numbers) {
  places_out[3 * entry] = vec4(hit.p, numbers.x);
  places_out[3 * entry + 1] = vec4(hit.n, numbers.y);
  places_out[3 * entry + 2] = vec4(hit.n_geometric, numbers.z);
}

const float LEAST_OF_SPREAD = 0.05;
const float LEAST_COSINE = 0.1;  // light along the surface tells little of where it comes from

// The sums of the finest fringes, where the light is glossy: its noise may be in them rather than in the mean.
vec2 finest_fringes(const float cosine[MAX_PITCHES], const float sine[MAX_PITCHES]) {
  vec2 found = vec2(0.0);
  float per_px = 0.0;
#define FINER_FRINGES(i)                                         \
  if (GLOSSY != 0 && i < N_PITCHES && (FUNDAMENTALS & (1 << i)) != 0) { \
    bool finer = params.pitch[i].x > per_px;                     \
    found = finer ? vec2(cosine[i], sine[i]) : found;            \
    per_px = finer ? params.pitch[i].x : per_px;                 \
  }
  REPEAT32(FINER_FRINGES)
  return found;
}

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
    hit.primitive = BY_LOBE != 0 ? int(texelFetch(gather_points, 3 * int(slot) + 2).w) : 0;
    hit.material = texelFetch(material_data, hit.primitive).xyz;
    seed = hash(uint(place.w) + hash(params.sampling_n.w)) + (BY_LOBE != 0 ? 8u : 0u);
  }

  float mean = 0.0, first_half = 0.0;
  float cosine[MAX_PITCHES], sine[MAX_PITCHES], direct[MAX_DIRECT];
  load_sums(push.resume != 0, slot, stride, mean, first_half, cosine, sine, direct);
  vec4 more = vec4(0.0);
  vec2 half_fringes = vec2(0.0);
  uint first_more = slot + uint(2 + 2 * N_PITCHES + N_DIRECT) * stride;
  for (uint k = 0; k < push.resume * 4u; ++k) more[k] = sums[first_more + k * stride];
  for (uint k = 0; k < push.resume * 2u; ++k) half_fringes[k] = sums[first_more + (4u + k) * stride];
  vec3 t, b, o = bounce_start(hit);
  basis(hit.n, t, b);
  footprint_middle = footprint_x = footprint_y = vec2(0.0);
  vec3 eye = -hit.p / sqrt(dot(hit.p, hit.p));
  MirrorWay mirrored[MIRROR_WAYS];
  for (int w = 0; w < N_WAYS; ++w) mirrored[w] = load_way(slot, w);
  for (uint k = push.first_sample; k < push.end_sample; ++k) {
    // directions of the hemisphere or of the lobe, then those of the ways of mirrored light
    bool of_way = N_WAYS > 0 && k >= n;
    uint way = of_way ? (k - n) / push.n_of_way : 0u, i = of_way ? (k - n) % push.n_of_way : k;
    uint of_n = of_way ? push.n_of_way : n;
    vec2 v = bounce_point(i, of_n, of_way ? seed + 2u + 2u * way : seed);
    vec3 d = by_cosine(v, hit.n, t, b);
    float steradian = PI / (float(n / 2u) * max(dot(d, hit.n), LEAST_OF_SPREAD));
    float share = 1.0 / float(n), of_lobe = share;
    if (BY_LOBE != 0) d = lobe_direction(v, hit, eye, t, b);
    if (GLOSSY != 0) {
      bool there = !of_way || mirrored[way].alpha > 0.0;  // a way that was not found takes nothing
      if (of_way) d = there ? along_way(v, mirrored[way]) : hit.n;
      vec2 taken = BY_LOBE != 0 ? lobe_and_density(d, hit, eye) : vec2(max(dot(d, hit.n), 0.0) / PI);
      float of_base = float(n) * taken.y, density = of_base;
      for (int w = 0; w < N_WAYS; ++w) density += float(push.n_of_way) * way_density(d, mirrored[w]);
      // lobes' light counts with all directions that could have taken it, other light with these alone
      share = of_way || taken.x == 0.0 ? 0.0 : taken.x / max(of_base, 1e-12);
      of_lobe = taken.x == 0.0 || !there ? 0.0 : taken.x / max(density, 1e-12);
      if (of_way || BY_LOBE != 0) steradian = min(2.0 / max(density, 1e-9), PI);
    }
    Hit other = bounce_hit(o, d);
    bool leaves = dot(d, hit.n_geometric) > 0.0, arrives = leaves && other.primitive >= 0;
    share *= arrives ? 1.0 : 0.0;
    of_lobe *= arrives ? 1.0 : 0.0;
    float before = mean, w = shade(other, real3(other.p), d, u, shadow_rays);
    float counted = GLOSSY != 0 ? mix(share, of_lobe, share_of_lobe) : share;
    w *= counted;
    // of what counts, less than of all light has been below the surface, or more
    if (SUBSURFACE != 0 && N_WAYS > 0) below.share *= counted > 0.0 ? share / counted : 0.0;
    mean += w;
    set_spread(other, d, steradian, u);
    vec2 fringes = finest_fringes(cosine, sine);
    add_patterns(w, w != 0.0 ? u : real2(0.0), cosine, sine, direct);
    if (MORE_BOUNCES != 0) add_light_of_cell(other, share * other.material.x, mean, cosine, sine, direct);
    first_half += 2u * i < of_n ? mean - before : 0.0;
    half_fringes += 2u * i < of_n ? finest_fringes(cosine, sine) - fringes : vec2(0.0);
    bool counts = !of_way && (leaves || BY_LOBE != 0);
    more += vec4(d * ((mean - before) / max(dot(d, hit.n), LEAST_COSINE)), counts ? 1.0 / float(n) : 0.0);
    if (WRITE_PLACES != 0 && !of_way)
      write_place(slot * n + k, other, vec3(arrives ? other.material.x : -1.0, 0.0, float(other.primitive)));
  }
  store_sums(slot, stride, mean, first_half, cosine, sine, direct);
  for (uint k = 0; k < 4u; ++k) sums[first_more + k * stride] = more[k];
  for (uint k = 0; k < 2u; ++k) sums[first_more + (4u + k) * stride] = half_fringes[k];
  report_status(pixel, shadow_rays);
}
