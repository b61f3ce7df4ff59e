#version 460
// SPDX-License-Identifier: Apache-2.0
// Pixels in which several facets of one mesh meet, without further rays. Inside a pixel the viewing direction is
// linear in the position, so that the plane through the camera and a triangle's side is a straight line in the
// pixel's square: each facet is clipped exactly. From the facet seen at the pixel's centre the search goes on
// across the sides that cross the square; without links between triangles it takes the facets that the
// neighbouring rays saw.
//  PIXELS_LISTED: every neighbouring ray saw the mesh lit. The pieces must fill the square.
//  PIXELS_OUTLINE: the mesh before nothing, or a border of facets that face the projector. Every piece must be
//  one that nothing can hide from camera or projector, or face away.
// objects: 1 where that does not hold; the pixel is then done by scan lines.
#extension GL_GOOGLE_include_directive : require
#define WITHOUT_SHADOW
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
#include "clip.glsl"

layout(local_size_x = BLOCK_WIDTH, local_size_y = BLOCK_HEIGHT) in;

const bool outline = PIXEL_LIST == PIXELS_OUTLINE;
const float AREA_TOLERANCE = 1e-3;
const float SEARCH_MARGIN = 0.7;  // px around an outline's pixel: what enters it only just is connected there

float mean = 0.0;
float cosine[MAX_PITCHES], sine[MAX_PITCHES], direct[MAX_DIRECT];

// The triangles to look at, in registers: lavapipe reads and writes indexed arrays lane by lane.
#define MOST_FACETS 16
#define FOR_FACETS(F) REPEAT16(F)
int facets[MOST_FACETS], n_facets = 0;

int facet(int i) {
  int found = facets[0];
#define PICK(k) found = i == k ? facets[k] : found;
  FOR_FACETS(PICK)
  return found;
}

void add_to_facets(int triangle, bool wanted) {
  bool known = false;
#define COMPARE(k) known = known || (k < n_facets && facets[k] == triangle);
  FOR_FACETS(COMPARE)
  bool add = wanted && !known;
#define PUT(k) facets[k] = add && n_facets == k ? triangle : facets[k];
  FOR_FACETS(PUT)
  n_facets += add ? 1 : 0;
}

struct Look {
  float w;
  bool faces_light;
  real2 u;
};

Look look_at_facet(const Primitive g, const PixelRays rays, int triangle, vec2 offset) {
  real3 d = ray_direction(rays, offset);
  Hit hit = no_hit();
  complete_mesh_hit(g, vec3(0.0), vec3(d), triangle, true, false, hit);
  place_hit(vec3(0.0), vec3(d), hit);
  Look look;
  uint no_rays = 0;
  look.w = shade(hit, refined_point(hit, real3(0.0), d), vec3(d), look.u, no_rays);
  vec3 to_light = params.projector_center.xyz - hit.p;
  look.faces_light = dot(hit.n, to_light) > 0.0 && dot(hit.n_geometric, to_light) > 0.0;
  return look;
}

void add_look(const Look look, float weight) {
  float w = look.w * weight;
  mean += w;
  add_patterns(w, w != 0.0 ? look.u : real2(0.0), cosine, sine, direct);
}

void main() {
  load_constants();
  uint slot = own_slot(), stride = push.n_blocks_band * BLOCK_PIXELS;
  uvec3 entry = listed_pixel(slot);
  ivec2 pixel = ivec2(entry.xy);
  PixelRays rays = pixel_rays(vec2(pixel));
  float half_fill = 0.5 * params.sampling.x;
  float reach = outline ? half_fill + SEARCH_MARGIN : half_fill;
  float hits = 0.0, finest = finest_fringe();
  load_sums(false, slot, stride, mean, hits, cosine, sine, direct);

#define NO_FACET(k) facets[k] = -1;
  FOR_FACETS(NO_FACET)
  int primitive = -1;
  bool good = true;
  for (int c = 0; c < (outline ? 9 : 1); ++c) {
    int k = (c + 4) % 9;
    ivec2 near = pixel + ivec2(k % 3 - 1, k / 3 - 1);
    float id = in_image(near) ? probe_at(near).w : 0.0;
    if (primitive < 0 && id != 0.0) primitive = primitive_of(id);
  }
  primitive = max(primitive, FIRST_MESH);
  Primitive g = fetch_primitive(primitive);
  vec3 o = to_object(g, vec3(0.0), 1.0), light = to_object(g, params.projector_center.xyz, 1.0) - o;
  // Direction in the object frame: d0 + du x + dv y.
  vec3 d0 = to_object(g, vec3(ray_direction(rays, vec2(0.0))), 0.0);
  vec3 du = to_object(g, vec3(direction_per_px(rays, 0)), 0.0), dv = to_object(g, vec3(direction_per_px(rays, 1)), 0.0);
  int first_triangle = int(g.d.y), first_link = int(g.d.z);
  for (int c = 0; c < (outline || !linked(LINKS_WALK) ? 9 : 1); ++c) {
    int k = (c + 4) % 9;
    ivec2 near = pixel + ivec2(k % 3 - 1, k / 3 - 1);
    float id = in_image(near) ? probe_at(near).w : 0.0;
    if (id != 0.0 && primitive_of(id) != primitive) id = 0.0;  // the pieces then do not fill the square
    int triangle = triangle_of(id, primitive);
    add_to_facets(triangle, id != 0.0);
    if (outline) {
      // Dark for another reason than facing away: a cast shadow or the border of the projected image.
      int i = 3 * (first_triangle + max(triangle, 0));
      vec4 a = FETCH_TRIANGLE(i);
      vec3 n = vec3(a.w, FETCH_TRIANGLE(i + 1).w, FETCH_TRIANGLE(i + 2).w), v = a.xyz - o;
      bool faces = dot(n, v) < 0.0 == dot(n, light - v) > 0.0;
      good = good && (id >= 0.0 || !faces);
    }
  }

  int own = facets[0];
  // The own facet as if it filled the pixel, by 2 x 2 Gauss; then, for the piece of each other one, the
  // difference between the two at the piece's centroid: small, since the surface is continuous.
  vec2 u_first = vec2(0.0);
  float swing_per_px = 0.0, own_w = 0.0;
  for (int j = 0; j < (outline ? 0 : 4); ++j) {
    vec2 offset = half_fill * 0.5773502692 * vec2((j & 1) != 0 ? 1.0 : -1.0, (j & 2) != 0 ? 1.0 : -1.0);
    Look look = look_at_facet(g, rays, own, offset);
    add_look(look, 0.25);
    own_w = look.w;
    u_first = j == 0 ? vec2(look.u) : u_first;
    float moved = length(vec2(look.u) - u_first) / (half_fill * 1.154700538);
    swing_per_px = j == 1 || j == 2 ? length(vec2(swing_per_px, finest * moved)) : swing_per_px;
  }
  float whole = 4.0 * half_fill * half_fill, covered = 0.0, error = 0.0, turn_error = 0.0;
  for (int f = 0; f < n_facets && f < MOST_FACETS; ++f) {
    int triangle = facet(f);
    int k = 3 * (first_triangle + triangle);
    vec4 a0 = FETCH_TRIANGLE(k), a1 = FETCH_TRIANGLE(k + 1), a2 = FETCH_TRIANGLE(k + 2);
    vec3 v0 = a0.xyz - o, v1 = a1.xyz - o, v2 = a2.xyz - o;
    // Differences first: the corners are much closer to each other than to the camera.
    vec3 n01 = cross(v0, v1 - v0), n12 = cross(v1, v2 - v1), n20 = cross(v2, v0 - v2);
    float side = dot(n01, v2) < 0.0 ? -1.0 : 1.0;
    vec3 e0 = line_in_square(side * n12, d0, du, dv), e1 = line_in_square(side * n20, d0, du, dv),
         e2 = line_in_square(side * n01, d0, du, dv);
    Piece piece = clip_to_square(e0, e1, e2, half_fill);
    float share = piece.area / whole;
    bool skipped = false;
    ivec4 link = ivec4(-1);
    if (linked(LINKS_WALK)) {
      link = FETCH_LINK(first_link + triangle);
      vec3 n = vec3(a0.w, a1.w, a2.w);
      bool faces_camera = dot(n, v0) * dot(n, cross(v1 - v0, v2 - v0)) < 0.0;
      // The far side of a closed mesh lies behind the near one.
      skipped = outline && !faces_camera && (link.w & LINK_CLOSED) != 0;
      bool seen = (link.w & LINK_SEEN) != 0 && (!outline || (link.w & LINK_CLOSED) != 0);
      good = good && (seen != skipped || share < 1e-6);
      bvec3 crossed = bvec3(side_enters(e0, e1, e2, reach), side_enters(e1, e2, e0, reach), side_enters(e2, e0, e1, reach));
      add_to_facets(link.x, crossed.x && !skipped && link.x >= 0);
      add_to_facets(link.y, crossed.y && !skipped && link.y >= 0);
      add_to_facets(link.z, crossed.z && !skipped && link.z >= 0);
    }
    share = skipped ? 0.0 : share;
    covered += share;
    Look before = Look(0.0, false, real2(0.0));
    for (int j = 0; j < (share <= 0.0 ? 0 : outline ? 4 : f > 0 ? 2 : 0); ++j) {
      vec2 at = outline ? rule_point(piece, j) : piece.middle;
      Look look = look_at_facet(g, rays, !outline && j == 1 ? own : triangle, at);
      if (outline) {
        bool lit = (link.w & LINK_LIT) != 0 || !linked(LINKS_SHADOW);
        good = good && (look.faces_light ? lit && look.w > 0.0 : look.w == 0.0);
        add_look(look, 0.25 * share);
        // What the rule leaves out, given the fringe's swing along the piece: third order (at most that of a
        // triangle), fourth order.
        float swing = j == 1 ? 0.5 * finest * length(vec2(look.u - before.u)) : 0.0;
        error += share * look.w * swing * swing * swing * (0.034 + 0.004 * swing);
      } else {
        add_look(look, j == 0 ? share : -share);
        // One point stands for the piece: the difference grows linearly from the common side, the fringe
        // turns meanwhile; a step in the shading stays, and loses contrast.
        float swing = j == 1 ? swing_per_px * 0.7071068 * length(piece.long_axis) : 0.0;
        float turn = finest * length(vec2(look.u - before.u));
        // Both change the contrast; the phase one order later.
        float left_out = share * 0.5 * swing * (look.w * turn + abs(look.w - before.w) * swing);
        error += left_out;
        turn_error += 0.5 * swing * left_out;
      }
      before = look;
    }
  }
  good = good && n_facets <= MOST_FACETS && (outline ? covered < 1.0 + AREA_TOLERANCE : abs(covered - 1.0) < AREA_TOLERANCE);
  hits = outline ? min(covered, 1.0) : 1.0;
  store_sums(slot, stride, mean, hits, cosine, sine, direct);
  // What 2 x 2 nodes leave on the own facet.
  float side_swing = 2.0 * half_fill * swing_per_px;
  error += outline ? 0.0 : own_w * side_swing * side_swing * side_swing * side_swing / 4320.0;
  turn_error /= max(mean, 1e-30);
  sums[slot + (2 + 2 * N_PITCHES + N_DIRECT) * stride] = error;
  sums[slot + (3 + 2 * N_PITCHES + N_DIRECT) * stride] = turn_error;
  objects[slot] = good ? 0 : 1;
  report_status(uvec2(pixel), 0);
}
