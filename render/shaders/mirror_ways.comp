#version 460
// SPDX-License-Identifier: Apache-2.0
// Finds the ways of the projector's light over shiny surfaces to places that gather (mirror_way.glsl): of some
// places of such surfaces those that mirror it nearly, and Newton's method from there.
#extension GL_GOOGLE_include_directive : require
#include "ray.glsl"
#include "sampling.glsl"
#include "patterns.glsl"
#include "shade.glsl"
#include "work_items.glsl"
#include "bounce.glsl"
#include "mirror_way.glsl"

layout(local_size_x = BLOCK_WIDTH, local_size_y = BLOCK_HEIGHT) in;

const float APART = 0.5;   // rad: ways of one surface that are nearer are one way
const int STEPS = 7;
const float STEP = 0.004;  // rad, between directions that tell how a surface turns
const float FARTHEST = 0.5, SHORTER = 0.3, SETTLED = 0.02;
const float WIDEST = 0.5;  // sr: wider lobes need no directions of their own

const MirrorWay NO_WAY = MirrorWay(vec3(0.0, 0.0, 1.0), 0.0, vec4(0.0));

void main() {
  load_constants();
  uint slot = own_slot();
  Hit hit = no_hit();
  vec4 place = texelFetch(gather_points, 3 * int(slot));
  hit.p = place.xyz;
  hit.n = texelFetch(gather_points, 3 * int(slot) + 1).xyz;
  hit.n_geometric = texelFetch(gather_points, 3 * int(slot) + 2).xyz;
  vec3 o = bounce_start(hit);

  vec3 found[MIRROR_WAYS];
  float off_by[MIRROR_WAYS];
  int met[MIRROR_WAYS];
  for (int w = 0; w < MIRROR_WAYS; ++w) {
    found[w] = hit.n;
    off_by[w] = 3.0;
    met[w] = -1;
  }
  for (uint k = 0u; k < push.n_mirrors; ++k) {
    vec4 at = texelFetch(mirror_places, int(2u * k));
    Hit other = no_hit();
    other.p = at.xyz;
    other.n = texelFetch(mirror_places, int(2u * k) + 1).xyz;
    other.primitive = int(at.w);
    vec3 d = other.p - o;
    float far_sq = dot(d, d);
    d /= sqrt(max(far_sq, 1e-12));
    vec3 off = off_mirror(other, d);
    bool meets = mirrors(off) && dot(d, hit.n) > 0.0 && dot(d, other.n) < 0.0 && far_sq > 1e-6;
    float by = meets ? sqrt(dot(off, off)) : 3.0;
    bool same0 = met[0] == other.primitive && dot(found[0], d) > cos(APART);
    bool same1 = met[1] == other.primitive && dot(found[1], d) > cos(APART);
    // the better of two alike, else in the place of the worse
    int into = same0 ? 0 : same1 ? 1 : off_by[0] > off_by[1] ? 0 : 1;
    if (by < off_by[into]) {
      found[into] = d;
      off_by[into] = by;
      met[into] = other.primitive;
    }
  }

  for (int w = 0; w < MIRROR_WAYS; ++w) {
    // Newton's method; steps that make it worse, or leave the surface as near its limb, are shortened
    MirrorWay way = NO_WAY;
    vec3 d = found[w], across, up;
    basis(d, across, up);
    vec2 step_ = vec2(0.0);
    float least = 1.0;
    for (int i = 0; i < (met[w] >= 0 ? STEPS : 0); ++i) {
      vec3 now = normalize(d + step_.x * across + step_.y * up), right, above, off[3];
      basis(now, right, above);
      Hit middle = no_hit();
      bool same = true;
      for (int k = 0; k < 3; ++k) {
        vec3 look = normalize(now + (k == 1 ? STEP : 0.0) * right + (k == 2 ? STEP : 0.0) * above);
        Hit other = bounce_hit(o, look);
        off[k] = off_mirror(other, look);
        if (k == 0) middle = other;
        same = same && mirrors(off[k]) && other.primitive == met[w];
      }
      vec3 x, y;
      basis(middle.n, x, y);
      vec3 per_right = (off[1] - off[0]) / STEP, per_above = (off[2] - off[0]) / STEP;
      vec4 turns = vec4(dot(x, per_right), dot(x, per_above), dot(y, per_right), dot(y, per_above));
      float area = turns.x * turns.w - turns.y * turns.z;
      vec2 left = vec2(dot(x, off[0]), dot(y, off[0]));
      float by = sqrt(dot(left, left)), alpha = alpha_of(middle);
      bool better = same && by < least && abs(area) > 1e-6;
      if (better) {
        d = now;
        across = right;
        up = above;
        least = by;
        step_ = -vec2(turns.w * left.x - turns.y * left.y, turns.x * left.y - turns.z * left.x) / area;
        step_ *= min(1.0, FARTHEST / max(sqrt(dot(step_, step_)), 1e-6));
        way = by < max(alpha, SETTLED) && alpha * alpha < WIDEST * abs(area) ? MirrorWay(d, alpha, turns) : NO_WAY;
      } else {
        step_ *= SHORTER;
      }
    }
    store_way(slot, w, way);
  }
  report_status(uvec2(slot, 0u), 0u);
}
