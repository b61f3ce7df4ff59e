// SPDX-License-Identifier: Apache-2.0
// bench_ray_query: one camera ray per invocation and, specialised, a shadow ray from what it hit to the
// projector. The includer says how: nearest() and blocked(). Rays, transform, lit side, origin of the shadow
// ray and output are the same for all ways. On lavapipe `if` skips no work, only loops end early.
#extension GL_GOOGLE_include_directive : require
#include "shared.h"

layout(local_size_x = BLOCK_WIDTH, local_size_y = BLOCK_HEIGHT) in;
layout(constant_id = 0) const int SHADOW = 0;

layout(push_constant) uniform PushBlock {
  vec4 T_object_cam[3];  // rows
  vec4 light;            // projector centre, camera frame; offset of a shadow ray's origin relative to |p|
  uvec4 blocks_across;   // x: in the image
} push;

layout(binding = 0) uniform samplerBuffer directions;  // x/z, y/z per pixel, camera frame
layout(binding = 1) uniform samplerBuffer triangle_data;
layout(std430, binding = 2) writeonly buffer OutputBlock { uvec2 seen[]; };  // bits of t, (triangle + 1) * 4 + state

#define FETCH_TRIANGLE(i) texelFetch(triangle_data, i)
#define FARTHEST_T 1e9
#define NO_SHADOW_RAY 0
#define LIT 1
#define SHADOWED 2

int nearest(vec3 d, inout float t);                               // triangle, -1: none
bool blocked(vec3 o, vec3 to_light, int triangle, bool enabled);  // any triangle closer than the light

void main() {
  uvec2 block = uvec2(gl_WorkGroupID.x % push.blocks_across.x, gl_WorkGroupID.x / push.blocks_across.x);
  uvec2 pixel = block * uvec2(BLOCK_WIDTH, BLOCK_HEIGHT) + gl_LocalInvocationID.xy;
  uint slot = pixel.y * push.blocks_across.x * BLOCK_WIDTH + pixel.x;
  vec3 d = vec3(texelFetch(directions, int(slot)).xy, 1.0);
  float t = FARTHEST_T;
  int triangle = nearest(d, t);
  uint state = NO_SHADOW_RAY;
  if (SHADOW != 0) {
    int k = 3 * max(triangle, 0);
    vec3 n_object = vec3(FETCH_TRIANGLE(k).w, FETCH_TRIANGLE(k + 1).w, FETCH_TRIANGLE(k + 2).w);
    vec3 n = n_object.x * push.T_object_cam[0].xyz + n_object.y * push.T_object_cam[1].xyz +
             n_object.z * push.T_object_cam[2].xyz;
    n = dot(n, d) > 0.0 ? -n : n;
    vec3 p = triangle >= 0 ? t * d : vec3(0.0, 0.0, -1.0);
    vec3 to_light = push.light.xyz - p;
    bool enabled = triangle >= 0 && dot(n, to_light) > 0.0;
    vec3 o = p + n * (push.light.w * max(max(abs(p.x), abs(p.y)), abs(p.z)));
    bool dark = blocked(o, to_light, triangle, enabled);
    state = enabled ? (dark ? SHADOWED : LIT) : NO_SHADOW_RAY;
  }
  seen[slot] = uvec2(floatBitsToUint(t), uint(triangle + 1) * 4u + state);
}
