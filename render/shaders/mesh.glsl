// SPDX-License-Identifier: Apache-2.0
// Triangle meshes: a two-wide BVH, while-while traversal with a private stack, a watertight triangle test.
// Node (4 x ivec4): left box min + child, left box max + 0, right min + child, right max + 0.
// Child >= 0: node; child < 0: leaf, ~child = first triangle * 8 + count - 1. Boxes are stored as
// integer bits because small integers as floats are denormals, which a device may flush.

const int MOST_WALK_STEPS = 8;
const int TRAVERSAL_DONE = -2147483647 - 1;

// Watertight after Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013, without
// their permutation of axes: a vertex relative to the origin is projected along the ray onto x, y, its
// depth is t. The projection of a vertex depends on that vertex alone, so that triangles with a common
// edge see the same two points, and the sign of an edge function, a difference of two rounded products,
// is that of the exact one or 0: nothing fits between them as long as 0 counts as inside.
struct Along {
  vec3 x, y, t;
};

Along along_ray(vec3 d) {
  vec3 a = abs(d);
  bool z = a.z >= max(a.x, a.y), y = !z && a.y >= a.x;
  vec3 px = z ? vec3(d.z, 0.0, -d.x) : y ? vec3(d.y, -d.x, 0.0) : vec3(-d.y, d.x, 0.0);
  vec3 py = z ? vec3(0.0, d.z, -d.y) : y ? vec3(0.0, -d.z, d.y) : vec3(-d.z, 0.0, d.x);
  vec3 pt = z ? vec3(0.0, 0.0, 1.0 / d.z) : y ? vec3(0.0, 1.0 / d.y, 0.0) : vec3(1.0 / d.x, 0.0, 0.0);
  return Along(px, py, pt);
}

// `precise`: fused into one operation, product and sum would round a vertex or an edge differently for its
// two triangles.
float dot_unfused(vec3 a, vec3 b) {
  precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
  return sum;
}

// Twice the areas that the ray cuts off opposite v0, v1, v2: all of one sign inside.
vec3 edge_functions(const Along along, vec3 v0, vec3 v1, vec3 v2) {
  precise float x0 = dot_unfused(along.x, v0), x1 = dot_unfused(along.x, v1), x2 = dot_unfused(along.x, v2);
  precise float y0 = dot_unfused(along.y, v0), y1 = dot_unfused(along.y, v1), y2 = dot_unfused(along.y, v2);
  precise vec3 e = vec3(x2 * y1 - y2 * x1, x0 * y2 - y0 * x2, x1 * y0 - y1 * x0);
  return e;
}

// Nearest triangle closer than `t` (any: the first found), -1 if none. `skip`: triangle to ignore.
int traverse(vec3 o, vec3 d, inout float t, int first_node, int first_triangle, bool any, int skip, bool enabled) {
  vec3 safe = vec3(abs(d.x) < 1e-20 ? 1e-20 : d.x, abs(d.y) < 1e-20 ? 1e-20 : d.y, abs(d.z) < 1e-20 ? 1e-20 : d.z);
  vec3 inv = 1.0 / safe;
  vec3 origin_inv = o * inv;
  Along along = along_ray(d);
  int stack[STACK_SIZE + 1];
  int depth = 1;
  stack[0] = TRAVERSAL_DONE;
  int node = enabled ? 0 : TRAVERSAL_DONE;
  int found = -1;
  while (node != TRAVERSAL_DONE) {
    while (node >= 0) {
      int base = 4 * (first_node + node);
      ivec4 a = FETCH_NODE(base), b = FETCH_NODE(base + 1), c = FETCH_NODE(base + 2), e = FETCH_NODE(base + 3);
      vec3 l0 = intBitsToFloat(a.xyz) * inv - origin_inv, l1 = intBitsToFloat(b.xyz) * inv - origin_inv;
      vec3 r0 = intBitsToFloat(c.xyz) * inv - origin_inv, r1 = intBitsToFloat(e.xyz) * inv - origin_inv;
      vec3 l_min = min(l0, l1), l_max = max(l0, l1), r_min = min(r0, r1), r_max = max(r0, r1);
      float l_near = max(max(l_min.x, l_min.y), max(l_min.z, 0.0));
      float r_near = max(max(r_min.x, r_min.y), max(r_min.z, 0.0));
      float l_far = min(min(l_max.x, l_max.y), l_max.z), r_far = min(min(r_max.x, r_max.y), r_max.z);
      // Slack of a few ulp: a box must not be missed because of rounding (Ize, JCGT 2(2), 2013). The
      // boxes themselves were grown on the CPU for the cancellation in b * inv - origin_inv.
      bool hit_l = l_near <= l_far * 1.0000008 && l_near < t;
      bool hit_r = r_near <= r_far * 1.0000008 && r_near < t;
      bool left_first = l_near <= r_near;
      int near = hit_l && (left_first || !hit_r) ? a.w : c.w;
      int far = near == a.w ? c.w : a.w;
      if (hit_l && hit_r) {
        stack[depth] = far;
        depth++;
      }
      if (hit_l || hit_r) {
        node = near;
      } else {
        depth--;
        node = stack[depth];
      }
    }
    if (node != TRAVERSAL_DONE) {
      int first = ~node >> 3, end = first + (~node & 7) + 1;
      for (int i = first; i < end; ++i) {
        int k = 3 * (first_triangle + i);
        vec3 v0 = FETCH_TRIANGLE(k).xyz - o, v1 = FETCH_TRIANGLE(k + 1).xyz - o, v2 = FETCH_TRIANGLE(k + 2).xyz - o;
        vec3 e = edge_functions(along, v0, v1, v2);
        float sum = e.x + e.y + e.z;
        float t_hit = dot(e, vec3(dot(along.t, v0), dot(along.t, v1), dot(along.t, v2))) / sum;
        bool inside = min(e.x, min(e.y, e.z)) >= 0.0 || max(e.x, max(e.y, e.z)) <= 0.0;
        if (inside && sum != 0.0 && t_hit > 0.0 && t_hit < t && i != skip) {
          t = t_hit;
          found = i;
        }
      }
      depth--;
      node = any && found >= 0 ? TRAVERSAL_DONE : stack[depth];
    }
  }
  return found;
}

// A ray from the camera, without the BVH: from a triangle near by across the sides that the ray lies beyond, to
// the one it meets. `settled`: that triangle cannot be hidden, so that no search is needed; `t` and the
// result are then those of traverse().
int walk(vec3 o, vec3 d, inout float t, int first_triangle, int first_link, int start, out bool settled) {
  Along along = along_ray(d);
  int found = -1, at = start;
  settled = false;
  for (int step = 0; step < MOST_WALK_STEPS && at >= 0; ++step) {
    int k = 3 * (first_triangle + at);
    vec3 v0 = FETCH_TRIANGLE(k).xyz - o, v1 = FETCH_TRIANGLE(k + 1).xyz - o, v2 = FETCH_TRIANGLE(k + 2).xyz - o;
    ivec4 link = FETCH_LINK(first_link + at);
    vec3 e = edge_functions(along, v0, v1, v2);
    float sum = e.x + e.y + e.z;
    float t_hit = dot(e, vec3(dot(along.t, v0), dot(along.t, v1), dot(along.t, v2))) / sum;
    e = sum < 0.0 ? -e : e;
    float least = min(e.x, min(e.y, e.z));
    bool inside = least >= 0.0 && sum != 0.0;
    int next = e.x == least ? link.x : e.y == least ? link.y : link.z;
    if (inside && (link.w & LINK_SEEN) != 0 && t_hit > 0.0) {
      settled = true;
      if (t_hit < t) {
        t = t_hit;
        found = at;
      }
    }
    at = inside ? -1 : next;
  }
  return found;
}

// Instance: a, b, c rows of T_object_cam; d first node, first triangle, first link,
// MESH_SMOOTH | MESH_ALBEDO.
vec3 to_object(const Primitive g, vec3 v, float w) {
  vec4 x = vec4(v, w);
  return vec3(dot(g.a, x), dot(g.b, x), dot(g.c, x));
}

vec3 direction_from_object(const Primitive g, vec3 v) { return v.x * g.a.xyz + v.y * g.b.xyz + v.z * g.c.xyz; }
