#version 460
// SPDX-License-Identifier: Apache-2.0
// The renderer's own traversal, as it stands in its kernels (render/shaders/mesh.glsl).
#extension GL_GOOGLE_include_directive : require
#include "ray_bench.glsl"

layout(binding = 3) uniform isamplerBuffer node_data;
#define FETCH_NODE(i) texelFetch(node_data, i)
#define FETCH_LINK(i) ivec4(-1)  // for walk(), which searches nothing and is not called here

struct Primitive {
  vec4 a, b, c, d;
};
#include "mesh.glsl"

Primitive instance() { return Primitive(push.T_object_cam[0], push.T_object_cam[1], push.T_object_cam[2], vec4(0.0)); }

int nearest(vec3 d, inout float t) {
  return traverse(to_object(instance(), vec3(0.0), 1.0), to_object(instance(), d, 0.0), t, 0, 0, false, -1, true);
}

bool blocked(vec3 o, vec3 to_light, int triangle, bool enabled) {
  float t = 1.0;
  return traverse(to_object(instance(), o, 1.0), to_object(instance(), to_light, 0.0), t, 0, 0, true, triangle,
                  enabled) >= 0;
}
