#version 460
// SPDX-License-Identifier: Apache-2.0
// Pixels in which several facets of one lit mesh meet, without further rays: each facet that the
// neighbouring centre rays saw is clipped against the pixel's square. Inside a
// pixel the viewing direction is linear in the position, so that the plane through the camera and a
// triangle's side is a straight line in the square. If the pieces do not fill the square, some facet was
// not seen (or one hides another): the pixel is reported back (objects = 1) and done by scan lines.
#extension GL_GOOGLE_include_directive : require
#define WITHOUT_SHADOW  // all neighbours see the projector
#include "bindings.glsl"
#include "camera.glsl"
#include "shapes.glsl"
#include "mesh.glsl"
#include "scene.glsl"
#include "refine.glsl"
#include "projector.glsl"
#include "patterns.glsl"
#include "shade.glsl"
#include "work_items.glsl"
#include "identity.glsl"

layout(local_size_x = BLOCK_WIDTH, local_size_y = BLOCK_HEIGHT) in;

const int MOST_CORNERS = 8;  // 4 of the square and one more per clip, and one to close
const float AREA_TOLERANCE = 1e-3;

// Keeps the part of the polygon where e.x x + e.y y + e.z >= 0 (Sutherland and Hodgman 1974).
void clip(inout vec2 polygon[MOST_CORNERS], inout int n, vec3 e) {
  vec2 kept[MOST_CORNERS];
  int m = 0;
  vec2 a = polygon[max(n - 1, 0)];
  float da = dot(e.xy, a) + e.z;
  for (int i = 0; i < n; ++i) {
    vec2 b = polygon[i];
    float db = dot(e.xy, b) + e.z;
    if ((da >= 0.0) != (db >= 0.0) && m < MOST_CORNERS) {
      kept[m] = a + (b - a) * (da / (da - db));
      m += 1;
    }
    if (db >= 0.0 && m < MOST_CORNERS) {
      kept[m] = b;
      m += 1;
    }
    a = b;
    da = db;
  }
  n = m;
  for (int i = 0; i < m; ++i) polygon[i] = kept[i];
}

// Area and centroid of a polygon.
vec3 area_and_centroid(vec2 polygon[MOST_CORNERS], int n) {
  vec3 sum = vec3(0.0);
  vec2 p0 = polygon[0];
  for (int i = 2; i < n; ++i) {
    vec2 a = polygon[i - 1] - p0, b = polygon[i] - p0;
    float twice = a.x * b.y - a.y * b.x;
    sum += twice * vec3(0.5, (a + b) / 6.0);
  }
  return vec3(abs(sum.x), p0 + (sum.x != 0.0 ? sum.yz / sum.x : vec2(0.0)));
}

void add_facet(const Primitive g, const PixelRays rays, int triangle, vec2 offset, float weight, inout float mean,
               inout float cosine[MAX_PITCHES], inout float sine[MAX_PITCHES], inout float direct[MAX_DIRECT]) {
  real3 d = ray_direction(rays, offset);
  Hit hit = no_hit();
  complete_mesh_hit(g, vec3(0.0), vec3(d), triangle, true, false, hit);
  place_hit(vec3(0.0), vec3(d), hit);
  real2 u;
  uint no_rays = 0;
  float w = shade(hit, refined_point(hit, real3(0.0), d), vec3(d), u, no_rays) * weight;
  mean += w;
  add_patterns(w, w != 0.0 ? u : real2(0.0), cosine, sine, direct);
}

void main() {
  load_constants();
  uint slot = own_slot(), stride = push.n_blocks_band * BLOCK_PIXELS;
  ivec2 pixel = ivec2(listed_pixel(slot).xy);
  PixelRays rays = pixel_rays(vec2(pixel));
  float half_fill = 0.5 * params.sampling.x;
  int primitive = primitive_of(probe_at(pixel).w);
  Primitive g = fetch_primitive(max(primitive, FIRST_MESH));
  vec3 o = to_object(g, vec3(0.0), 1.0);
  // Direction in the object frame: d0 + du x + dv y.
  vec3 d0 = to_object(g, vec3(ray_direction(rays, vec2(0.0))), 0.0);
  vec3 du = to_object(g, vec3(direction_per_px(rays, 0)), 0.0), dv = to_object(g, vec3(direction_per_px(rays, 1)), 0.0);

  float mean = 0.0, hits = 0.0;
  float cosine[MAX_PITCHES], sine[MAX_PITCHES], direct[MAX_DIRECT];
  load_sums(false, slot, stride, mean, hits, cosine, sine, direct);
  // The facets seen around, each once; the own one first.
  int facets[9], n_facets = 0;
  for (int c = 0; c < 9; ++c) {
    int k = (c + 4) % 9;
    int triangle = triangle_of(probe_at(pixel + ivec2(k % 3 - 1, k / 3 - 1)).w, primitive);
    bool again = false;
    for (int i = 0; i < n_facets; ++i) again = again || facets[i] == triangle;
    if (!again) {
      facets[n_facets] = triangle;
      n_facets += 1;
    }
  }
  float whole = 4.0 * half_fill * half_fill, covered = 0.0;
  // The own facet as if it filled the pixel, by 2 x 2 Gauss; then, for the piece of each other one, the
  // difference between the two at the piece's centroid: small, since the surface is continuous.
  for (int j = 0; j < 4; ++j) {
    vec2 offset = half_fill * 0.5773502692 * vec2((j & 1) != 0 ? 1.0 : -1.0, (j & 2) != 0 ? 1.0 : -1.0);
    add_facet(g, rays, facets[0], offset, 0.25, mean, cosine, sine, direct);
  }
  for (int f = 0; f < n_facets; ++f) {
    int first = 3 * (int(g.d.y) + facets[f]);
    vec3 v0 = FETCH_TRIANGLE(first).xyz - o, v1 = FETCH_TRIANGLE(first + 1).xyz - o, v2 = FETCH_TRIANGLE(first + 2).xyz - o;
    vec3 n01 = cross(v0, v1), n12 = cross(v1, v2), n20 = cross(v2, v0);
    float side = dot(n01, v2) < 0.0 ? -1.0 : 1.0;
    vec2 polygon[MOST_CORNERS];
    polygon[0] = vec2(-half_fill, -half_fill);
    polygon[1] = vec2(half_fill, -half_fill);
    polygon[2] = vec2(half_fill, half_fill);
    polygon[3] = vec2(-half_fill, half_fill);
    int n = 4;
    clip(polygon, n, side * vec3(dot(du, n01), dot(dv, n01), dot(d0, n01)));
    clip(polygon, n, side * vec3(dot(du, n12), dot(dv, n12), dot(d0, n12)));
    clip(polygon, n, side * vec3(dot(du, n20), dot(dv, n20), dot(d0, n20)));
    vec3 piece = area_and_centroid(polygon, n);
    float share = piece.x / whole;
    covered += share;
    for (int j = 0; j < (f > 0 && share > 0.0 ? 2 : 0); ++j)
      add_facet(g, rays, j == 0 ? facets[f] : facets[0], piece.yz, j == 0 ? share : -share, mean, cosine, sine, direct);
  }
  hits = 1.0;
  store_sums(slot, stride, mean, hits, cosine, sine, direct);
  objects[slot] = abs(covered - 1.0) < AREA_TOLERANCE ? 0 : 1;
  report_status(uvec2(pixel), 0);
}
