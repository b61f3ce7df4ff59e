#version 460
// SPDX-License-Identifier: Apache-2.0
// VK_KHR_ray_query: one instance of the mesh, all triangles opaque, seen from both sides. A ray query cannot
// leave out the triangle it starts from: the shadow ray's origin off the surface has to do.
#extension GL_EXT_ray_query : require
#extension GL_GOOGLE_include_directive : require
#include "ray_bench.glsl"

layout(binding = 3) uniform accelerationStructureEXT scene;

int nearest(vec3 d, inout float t) {
  rayQueryEXT query;
  rayQueryInitializeEXT(query, scene, gl_RayFlagsOpaqueEXT, 0xFF, vec3(0.0), 0.0, d, t);
  while (rayQueryProceedEXT(query)) {
  }
  bool hit = rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionTriangleEXT;
  t = hit ? rayQueryGetIntersectionTEXT(query, true) : t;
  return hit ? rayQueryGetIntersectionPrimitiveIndexEXT(query, true) : -1;
}

bool blocked(vec3 o, vec3 to_light, int triangle, bool enabled) {
  bool hit = false;
  for (int once = 0; once < int(enabled); ++once) {
    rayQueryEXT query;
    rayQueryInitializeEXT(query, scene, gl_RayFlagsOpaqueEXT | gl_RayFlagsTerminateOnFirstHitEXT, 0xFF, o, 0.0,
                          to_light, 1.0);
    while (rayQueryProceedEXT(query)) {
    }
    hit = rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionTriangleEXT;
  }
  return hit;
}
