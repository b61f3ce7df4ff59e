#version 460
// SPDX-License-Identifier: Apache-2.0
// Pixels in which several facets of one mesh meet, without further rays. Inside a pixel the viewing direction is
// linear in the position, so that the plane through the camera and a triangle's side is a straight line in the
// pixel's square: each facet is clipped exactly. From the facet seen at the pixel's centre the search goes on
// across the sides that cross the square; without links between triangles it takes the facets that the
// neighbouring rays saw.
//  PIXELS_LISTED: every neighbouring ray, or those along the pixel's border, saw the mesh lit. The pieces must fill the square. The own facet stands for
//  all; each other piece adds how it differs at its middle.
//  PIXELS_PIECES: the same pixels, every piece by a rule of its own: for what the former is not good enough for. One
//  invocation = one of equal squares of the pixel, reached from the own facet across sides.
//  PIXELS_OUTLINE: the mesh before nothing, or a border of facets that face the projector. Every piece must be
//  one that nothing can hide from camera or projector, or face away.
// objects: FACETS_ (shared.h); what does not hold is done by scan lines.
#extension GL_GOOGLE_include_directive : require
#define WITHOUT_SHADOW
#include "ray.glsl"
#include "patterns.glsl"
#include "shade.glsl"
#include "work_items.glsl"
#include "identity.glsl"
#include "clip.glsl"

layout(local_size_x = BLOCK_WIDTH, local_size_y = BLOCK_HEIGHT) in;

const bool outline = PIXEL_LIST == PIXELS_OUTLINE, by_piece = PIXEL_LIST != PIXELS_LISTED;
const float AREA_TOLERANCE = 1e-3;
const int MOST_STEPS = 128;
const float MOST_QUICK_SWING = 1.5;  // rad of the finest fringe along an axis of the pixel
const float SEARCH_MARGIN = 0.7;  // px around an outline's pixel: what enters it only just is connected there

float mean = 0.0;
float cosine[MAX_PITCHES], sine[MAX_PITCHES], direct[MAX_DIRECT];

// The triangles to look at, in registers: lavapipe reads and writes indexed arrays lane by lane.
// At the outline of a curved mesh many are seen edge-on: 17 to 32 on a third of the free-form part's.
const int MOST_FACETS = by_piece ? 32 : 16;
#define FOR_FACETS(F) \
  REPEAT16(F)         \
  if (by_piece) {     \
    REPEAT16_ON(F)    \
  }
int facets[32], n_facets = 0;

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
  Below below;
};

Look look_at_facet(const Primitive g, const PixelRays rays, int triangle, vec2 offset) {
  real3 d = ray_direction(rays, offset);
  Hit hit = no_hit();
  complete_mesh_hit(g, vec3(0.0), vec3(d), triangle, true, false, hit);
  place_hit(vec3(0.0), vec3(d), hit);
  Look look;
  uint no_rays = 0;
  look.w = shade(hit, refined_point(hit, real3(0.0), d), vec3(d), look.u, no_rays);
  look.below = below;
  vec3 to_light = params.projector_center.xyz - hit.p;
  look.faces_light = dot(hit.n, to_light) > 0.0 && dot(hit.n_geometric, to_light) > 0.0;
  return look;
}

void add_look(const Look look, float weight) {
  float w = look.w * weight;
  mean += w;
  below = look.below;
  add_patterns(w, w != 0.0 ? look.u : real2(0.0), cosine, sine, direct);
}

// Also where x is not a number.
float at_most(float x, float limit) { return x < limit ? x : limit; }

// By nine points. What that leaves out, given the fringe's swing along the piece's axes: held against random triangles in
// a square, of fringes up to 1 rad per pixel, it bounds the error.
void add_piece(const Primitive g, const PixelRays rays, int triangle, bool lit, const Piece piece, float share, float finest,
               inout bool good, inout float error) {
  vec2 first_short = vec2(0.0), first_long = vec2(0.0);
  float swing_long = 0.0, swing_short = 0.0, brightest = 0.0, darkest = 1e30;
  for (int j = 0; j < (share > 0.0 ? 9 : 0); ++j) {
    float weight;
    vec2 at = rule_point(piece, j, weight);
    Look look = look_at_facet(g, rays, triangle, at);
    good = good && (!outline || (look.faces_light ? lit && look.w > 0.0 : look.w == 0.0));
    add_look(look, weight * share);
    first_short = j == 1 ? vec2(look.u) : first_short;
    first_long = j == 3 ? vec2(look.u) : first_long;
    swing_long = j == 5 ? 0.5 * finest * length(vec2(look.u) - first_long) : swing_long;
    swing_short = j == 7 ? 0.5 * finest * length(vec2(look.u) - first_short) : swing_short;
    brightest = max(brightest, look.w);
    darkest = min(darkest, look.w);
  }
  // Points beyond a sliver seen edge-on may be anywhere; no piece can be wrong by more than twice what it adds.
  float a = at_most(swing_long * swing_long, 100.0), b = at_most(swing_short * swing_short, 100.0);
  float left_out = min(0.005 * (a * a + b * b) + 0.02 * a * b, 2.0);
  // Vertex normals may turn away from the light inside of the piece.
  left_out += brightest > 0.0 && darkest == 0.0 ? 0.25 : 0.0;
  error += share * brightest * left_out;
}

// How the piece differs from the own facet there, at its middle.
void add_difference(const Primitive g, const PixelRays rays, int own, int triangle, const Piece piece, float share,
                    float finest, float swing_per_px, inout float error, inout float turn_error) {
  Look look = look_at_facet(g, rays, triangle, piece.middle), before = look_at_facet(g, rays, own, piece.middle);
  add_look(look, share);
  add_look(before, -share);
  // One point stands for the piece: the difference grows linearly from the common side, the fringe
  // turns meanwhile; a step in the shading stays, and loses contrast.
  float swing = swing_per_px * 0.7071068 * length(piece.long_axis), turn = finest * length(vec2(look.u - before.u));
  // Both change the contrast; the phase one order later.
  float left_out = share * at_most(0.5 * swing * (before.w * turn + abs(look.w - before.w) * swing), 2.0 * max(look.w, before.w));
  error += left_out;
  turn_error += 0.5 * swing * left_out;
}

// The triangle's sides as lines around `center` in the pixel.
struct Sides {
  vec3 e0, e1, e2;
};

// A mesh as the pixel sees it, in the object frame: the directions d0 + du x + dv y from `o`.
struct MeshView {
  vec3 o, d0, du, dv;
  int first_triangle, first_link;
};

Sides sides_of(const MeshView m, int triangle, vec2 center, out vec3 v0, out vec3 n_geometric, out vec3 n) {
  int k = 3 * (m.first_triangle + triangle);
  vec4 a0 = FETCH_TRIANGLE(k), a1 = FETCH_TRIANGLE(k + 1), a2 = FETCH_TRIANGLE(k + 2);
  v0 = a0.xyz - m.o;
  vec3 v1 = a1.xyz - m.o, v2 = a2.xyz - m.o;
  n = vec3(a0.w, a1.w, a2.w);
  n_geometric = cross(v1 - v0, v2 - v0);
  // Differences first: the corners are much closer to each other than to the camera.
  vec3 n01 = cross(v0, v1 - v0), n12 = cross(v1, v2 - v1), n20 = cross(v2, v0 - v2);
  float side = dot(n01, v2) < 0.0 ? -1.0 : 1.0;
  return Sides(moved_line(line_in_square(side * n12, m.d0, m.du, m.dv), center),
                 moved_line(line_in_square(side * n20, m.d0, m.du, m.dv), center),
                 moved_line(line_in_square(side * n01, m.d0, m.du, m.dv), center));
}

// From the facet at the pixel's centre to the one at `center`, across the side that parts them most; -1: over the mesh's border.
int walk_to(const MeshView m, int triangle, vec2 center) {
  bool inside = false;
  for (int step = 0; step < MOST_STEPS && !inside && triangle >= 0; ++step) {
    vec3 v0, n_geometric, n;
    Sides s = sides_of(m, triangle, center, v0, n_geometric, n);
    float most = min(s.e0.z, min(s.e1.z, s.e2.z));
    inside = most >= 0.0;
    ivec4 link = FETCH_LINK(m.first_link + triangle);
    triangle = inside ? triangle : most == s.e0.z ? link.x : most == s.e1.z ? link.y : link.z;
  }
  return inside ? triangle : -1;
}

void main() {
  load_constants();
  uint slot = own_slot(), stride = push.n_blocks_band * BLOCK_PIXELS;
  int parts = PIXEL_LIST == PIXELS_PIECES ? int(params.image.z) : 1, square = int(slot) % (parts * parts);
  uvec3 entry = listed_pixel(slot / uint(parts * parts));
  ivec2 pixel = ivec2(entry.xy);
  PixelRays rays = pixel_rays(vec2(pixel));
  float half_fill = 0.5 * params.sampling.x, part = half_fill / float(parts);
  vec2 center = (vec2(square % parts, square / parts) + 0.5) * (2.0 * part) - half_fill;
  float reach = outline ? half_fill + SEARCH_MARGIN : part;
  float hits = 0.0, finest = finest_swing();
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
  MeshView m = MeshView(to_object(g, vec3(0.0), 1.0), to_object(g, vec3(ray_direction(rays, vec2(0.0))), 0.0),
                        to_object(g, vec3(direction_per_px(rays, 0)), 0.0), to_object(g, vec3(direction_per_px(rays, 1)), 0.0),
                        int(g.d.y), int(g.d.z));
  vec3 light = to_object(g, params.projector_center.xyz, 1.0) - m.o;
  for (int c = 0; c < (outline || !linked(LINKS_WALK) ? 9 : 1); ++c) {
    int k = (c + 4) % 9;
    ivec2 near = pixel + ivec2(k % 3 - 1, k / 3 - 1);
    float id = in_image(near) ? probe_at(near).w : 0.0;
    if (id != 0.0 && primitive_of(id) != primitive) id = 0.0;  // the pieces then do not fill the square
    int triangle = triangle_of(id, primitive);
    if (linked(LINKS_WALK) && parts > 1) {
      triangle = walk_to(m, triangle, center);
      good = good && triangle >= 0;
      triangle = max(triangle, 0);
    }
    add_to_facets(triangle, id != 0.0);
    if (outline) {
      // Dark for another reason than facing away: a cast shadow or the border of the projected image.
      int i = 3 * (m.first_triangle + max(triangle, 0));
      vec4 a = FETCH_TRIANGLE(i);
      vec3 n = vec3(a.w, FETCH_TRIANGLE(i + 1).w, FETCH_TRIANGLE(i + 2).w), v = a.xyz - m.o;
      bool faces = dot(n, v) < 0.0 == dot(n, light - v) > 0.0;
      good = good && (id >= 0.0 || !faces);
    }
  }

  bool beyond = beyond_list(slot / uint(parts * parts));
  n_facets = beyond ? 0 : n_facets;
  int own = facets[0];
  // The own facet as if it filled the pixel, by 2 x 2 Gauss; then, for the piece of each other one, the
  // difference between the two at the piece's centroid: small, since the surface is continuous.
  vec2 u_first = vec2(0.0);
  float swing_per_px = 0.0, own_w = 0.0;
  for (int j = 0; j < (by_piece || beyond ? 0 : 4); ++j) {
    vec2 offset = half_fill * 0.5773502692 * vec2((j & 1) != 0 ? 1.0 : -1.0, (j & 2) != 0 ? 1.0 : -1.0);
    Look look = look_at_facet(g, rays, own, offset);
    add_look(look, 0.25);
    own_w = look.w;
    u_first = j == 0 ? vec2(look.u) : u_first;
    float moved = length(vec2(look.u) - u_first) / (half_fill * 1.154700538);
    swing_per_px = j == 1 || j == 2 ? length(vec2(swing_per_px, finest * moved)) : swing_per_px;
  }
  float whole = 4.0 * half_fill * half_fill, covered = 0.0, error = 0.0, turn_error = 0.0;
  for (int f = 0; f < n_facets && n_facets <= MOST_FACETS; ++f) {
    int triangle = facet(f);
    vec3 v0, n_geometric, n;
    Sides s = sides_of(m, triangle, center, v0, n_geometric, n);
    bool skipped = false, hidden = false;
    ivec4 link = ivec4(-1);
    if (linked(LINKS_WALK)) {
      link = FETCH_LINK(m.first_link + triangle);
      bool faces_camera = dot(n, v0) * dot(n, n_geometric) < 0.0;
      // The far side of a closed mesh lies behind the near one.
      skipped = outline && !faces_camera && (link.w & LINK_CLOSED) != 0;
      bool seen = (link.w & LINK_SEEN) != 0 && (!outline || (link.w & LINK_CLOSED) != 0);
      hidden = seen == skipped;
      bvec3 crossed = bvec3(side_enters(s.e0, s.e1, s.e2, reach), side_enters(s.e1, s.e2, s.e0, reach),
                            side_enters(s.e2, s.e0, s.e1, reach));
      add_to_facets(link.x, crossed.x && !skipped && link.x >= 0);
      add_to_facets(link.y, crossed.y && !skipped && link.y >= 0);
      add_to_facets(link.z, crossed.z && !skipped && link.z >= 0);
    }
    bool lit = (link.w & LINK_LIT) != 0 || !linked(LINKS_SHADOW);
    Piece piece = clip_to_square(s.e0, s.e1, s.e2, part);
    piece.middle += center;
    float share = piece.area / whole;
    good = good && (!hidden || share < 1e-6);
    share = skipped ? 0.0 : share;
    covered += share;
    if (by_piece)
      add_piece(g, rays, triangle, lit, piece, share, finest, good, error);
    else if (f > 0 && share > 0.0)
      add_difference(g, rays, own, triangle, piece, share, finest, swing_per_px, error, turn_error);
  }
  float to_cover = 1.0 / float(parts * parts);
  // Four nodes on the own facet say nothing about more of the fringe: then piece by piece, too.
  float side_swing = 2.0 * half_fill * swing_per_px;
  bool too_many = n_facets > MOST_FACETS || (!by_piece && side_swing > MOST_QUICK_SWING);
  good = good && (too_many || (outline ? covered < 1.0 + AREA_TOLERANCE : abs(covered - to_cover) < AREA_TOLERANCE * to_cover));
  hits = outline ? min(covered, 1.0) : to_cover;
  store_sums(slot, stride, mean, hits, cosine, sine, direct);
  // What 2 x 2 nodes leave on the own facet.
  error += by_piece ? 0.0 : own_w * side_swing * side_swing * side_swing * side_swing / 4320.0;
  sums[slot + (2 + 2 * N_PITCHES + N_DIRECT) * stride] = error;
  sums[slot + (3 + 2 * N_PITCHES + N_DIRECT) * stride] = by_piece ? error : turn_error;
  objects[slot] = !good ? FACETS_UNKNOWN : too_many ? FACETS_TOO_MANY : FACETS_DONE;
  report_status(uvec2(pixel), 0);
}
