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

const float APART = 0.5;     // rad: ways of one surface that are nearer are one way
const int STEPS = 6;
const float BESIDE = 0.004;  // of the distance, between places that tell how a surface turns
const float FARTHEST = 0.5, SHORTER = 0.3, SETTLED = 0.02;
const float WIDEST = 0.5;    // sr: wider lobes need no directions of their own

const MirrorWay NO_WAY = MirrorWay(vec3(0.0, 0.0, 1.0), 0.0, vec4(0.0));

// The place of a surface below or above a point near it, along a normal.
Hit foot(vec3 point, vec3 n, float height) { return bounce_hit(point + height * n, -n); }

void main() {
  load_constants();
  uint slot = own_slot();
  vec3 o = texelFetch(gather_points, 3 * int(slot)).xyz, n = texelFetch(gather_points, 3 * int(slot) + 1).xyz;

  vec3 found[MIRROR_WAYS], normal[MIRROR_WAYS];
  float off_by[MIRROR_WAYS];
  int met[MIRROR_WAYS];
  for (int w = 0; w < MIRROR_WAYS; ++w) {
    found[w] = o + n;
    normal[w] = -n;
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
    bool meets = mirrors(off) && dot(d, n) > 0.0 && dot(d, other.n) < 0.0 && far_sq > 1e-6;
    float by = meets ? sqrt(dot(off, off)) : 3.0;
    bool same0 = met[0] == other.primitive && dot(normalize(found[0] - o), d) > cos(APART);
    bool same1 = met[1] == other.primitive && dot(normalize(found[1] - o), d) > cos(APART);
    // the better of two alike, else in the place of the worse
    int into = same0 ? 0 : same1 ? 1 : off_by[0] > off_by[1] ? 0 : 1;
    if (by < off_by[into]) {
      found[into] = other.p;
      normal[into] = other.n;
      off_by[into] = by;
      met[into] = other.primitive;
    }
  }

  for (int w = 0; w < MIRROR_WAYS; ++w) {
    // Newton's method over the surface; steps that make it worse, or leave it, are shortened
    MirrorWay way = NO_WAY;
    vec3 p = found[w], up = normal[w], x, y;
    basis(up, x, y);
    float far = sqrt(dot(p - o, p - o)), least = 1.0;
    vec3 step_ = vec3(0.0);
    for (int i = 0; i < (met[w] >= 0 ? STEPS : 0); ++i) {
      vec3 start = p + step_, off[3], look[3];
      float beside = BESIDE * far, height = sqrt(dot(step_, step_)) + beside;
      Hit middle = no_hit();
      bool same = true;
      for (int k = 0; k < 3; ++k) {
        Hit other = foot(start + (k == 1 ? beside : 0.0) * x + (k == 2 ? beside : 0.0) * y, up, height);
        look[k] = normalize(other.p - o);
        off[k] = off_mirror(other, look[k]);
        if (k == 0) middle = other;
        same = same && mirrors(off[k]) && other.primitive == met[w];
      }
      // what places beside turn the normal against the bisector, and the direction in which they are seen
      vec3 right, above, t, b;
      basis(middle.n, right, above);
      basis(look[0], t, b);
      vec3 turn_x = off[1] - off[0], turn_y = off[2] - off[0], look_x = look[1] - look[0], look_y = look[2] - look[0];
      mat2 turns = mat2(dot(right, turn_x), dot(above, turn_x), dot(right, turn_y), dot(above, turn_y));
      mat2 looks = mat2(dot(t, look_x), dot(b, look_x), dot(t, look_y), dot(b, look_y));
      vec2 left = vec2(dot(right, off[0]), dot(above, off[0]));
      float by = sqrt(dot(left, left)), alpha = alpha_of(middle);
      float turned = determinant(turns), looked = determinant(looks);
      if (same && by < least && abs(turned) > 1e-12 && abs(looked) > 1e-12) {
        vec2 to = -beside * (inverse(turns) * left);
        vec3 along = to.x * x + to.y * y;
        mat2 per_look = turns * inverse(looks);
        p = middle.p;
        up = middle.n;
        basis(up, x, y);
        least = by;
        far = sqrt(dot(p - o, p - o));
        step_ = along - dot(along, up) * up;
        step_ *= min(1.0, FARTHEST * far / max(sqrt(dot(step_, step_)), 1e-6));
        bool narrow = alpha * alpha * abs(looked) < WIDEST * abs(turned);
        way = NO_WAY;
        if (by < max(alpha, SETTLED) && narrow)
          way = MirrorWay(look[0], alpha, vec4(per_look[0].x, per_look[1].x, per_look[0].y, per_look[1].y));
      } else if (i == 0) {
        break;  // nothing to begin with
      } else {
        step_ *= SHORTER;
      }
    }
    store_way(slot, w, way);
  }
  report_status(uvec2(slot, 0u), 0u);
}
