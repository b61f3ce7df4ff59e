// SPDX-License-Identifier: Apache-2.0
// Nearest hit over all objects, and whether the projector sees a point.

struct Hit {
  float t;
  vec3 p;            // camera frame, mm
  vec3 n;            // shading normal, faces the viewer
  vec3 n_geometric;  // of the surface itself, faces the viewer
  vec3 material;     // diffuse, specular, shininess
  int primitive;     // -1: nothing
  int triangle;      // meshes
};

void hit_mesh(int i, vec3 o, vec3 d, inout Hit hit) {
  vec4 instance = primitives[4 * i + 3];
  int first_triangle = floatBitsToInt(instance.y);
  vec3 o_object = to_object(i, o, 1.0), d_object = to_object(i, d, 0.0);
  float t = hit.t;
  int triangle = traverse(o_object, d_object, t, floatBitsToInt(instance.x), first_triangle, false, -1, true);
  bool found = triangle >= 0;
  int k = 3 * (first_triangle + max(triangle, 0));
  vec3 v0 = FETCH_TRIANGLE(k).xyz;
  vec3 e1 = FETCH_TRIANGLE(k + 1).xyz - v0, e2 = FETCH_TRIANGLE(k + 2).xyz - v0;
  vec3 n = cross(e1, e2);
  // The plane form is more accurate than Moeller-Trumbore's t.
  vec3 s = v0 - o_object;
  t = dot(n, s) / dot(n, d_object);
  vec3 n_geometric = direction_from_object(i, n / length(n));
  vec3 n_shading = n_geometric;
  vec3 material = materials[i].xyz;
  if (CORNERS != 0) {
    vec3 h = cross(d_object, e2), q = cross(e1, s);
    float inv_det = 1.0 / dot(e1, h);
    float u = -dot(s, h) * inv_det, v = dot(d_object, q) * inv_det;
    int c = 3 * (floatBitsToInt(instance.z) + max(triangle, 0));
    vec4 corner = (1.0 - u - v) * FETCH_CORNER(c) + u * FETCH_CORNER(c + 1) + v * FETCH_CORNER(c + 2);
    int flags = int(instance.w);
    if ((flags & MESH_SMOOTH) != 0) n_shading = direction_from_object(i, corner.xyz / length(corner.xyz));
    if ((flags & MESH_ALBEDO) != 0) material.x *= corner.w;
  }
  if (found) {
    hit.t = t;
    hit.n = n_shading;
    hit.n_geometric = n_geometric;
    hit.material = material;
    hit.primitive = i;
    hit.triangle = triangle;
  }
}

Hit closest_hit(vec3 o, vec3 d) {
  const bool from_origin = LENS_DISK == 0;
  Hit hit;
  hit.t = INFINITY_T;
  hit.n = vec3(0.0, 0.0, -1.0);
  hit.n_geometric = hit.n;
  hit.material = vec3(0.0, 0.0, 1.0);
  hit.primitive = -1;
  hit.triangle = -1;
  for (int i = 0; i < N_SPHERES; ++i) {
    vec2 t = sphere_roots(i, o, d, from_origin);
    if (t.x > 0.0 && t.x < hit.t) {
      hit.t = t.x;
      hit.n = (o + t.x * d - primitives[4 * i].xyz) / primitives[4 * i].w;
      hit.material = materials[i].xyz;
      hit.primitive = i;
    }
  }
  for (int i = FIRST_PLANE; i < FIRST_CYLINDER; ++i) {
    float t = plane_root(i, o, d);
    if (t > 0.0 && t < hit.t) {
      hit.t = t;
      hit.n = primitives[4 * i].xyz;
      hit.material = materials[i].xyz;
      hit.primitive = i;
    }
  }
  for (int i = FIRST_CYLINDER; i < FIRST_MESH; ++i) {
    vec2 roots = cylinder_roots(i, o, d, from_origin);
    float t = roots.x > 0.0 ? roots.x : roots.y;
    if (t > 0.0 && t < hit.t) {
      vec3 axis = primitives[4 * i + 1].xyz;
      vec3 r = o + t * d - primitives[4 * i].xyz;
      hit.t = t;
      hit.n = (r - dot(r, axis) * axis) / primitives[4 * i].w;
      hit.material = materials[i].xyz;
      hit.primitive = i;
    }
  }
  hit.n_geometric = hit.n;
  for (int i = FIRST_MESH; i < FIRST_MESH + N_MESHES; ++i) hit_mesh(i, o, d, hit);
  hit.p = o + hit.t * d;
  if (hit.primitive < 0) hit.p = vec3(0.0, 0.0, -1.0);
  if (dot(hit.n_geometric, d) > 0.0) {
    hit.n_geometric = -hit.n_geometric;
    hit.n = -hit.n;
  }
  return hit;
}

// Is anything between the hit and the projector centre at hit.p + to_light? Only asked for points
// whose lit side is seen, so a sphere, a plane or the outside of a cylinder cannot hide itself.
bool occluded(const Hit hit, vec3 to_light, bool enabled) {
  vec3 o = hit.p + hit.n_geometric * (params.light.y * max(max(abs(hit.p.x), abs(hit.p.y)), abs(hit.p.z)));
  bool blocked = false;
  for (int i = 0; i < N_SPHERES; ++i) {
    vec2 t = sphere_roots(i, o, to_light, false);
    bool between = (t.x > 0.0 && t.x < 1.0) || (t.y > 0.0 && t.y < 1.0);
    blocked = blocked || (between && i != hit.primitive);
  }
  for (int i = FIRST_PLANE; i < FIRST_CYLINDER; ++i) {
    float t = plane_root(i, o, to_light);
    blocked = blocked || (t > 0.0 && t < 1.0 && i != hit.primitive);
  }
  for (int i = FIRST_CYLINDER; i < FIRST_MESH; ++i) {
    vec2 t = cylinder_roots(i, o, to_light, false);
    bool between = (t.x > 0.0 && t.x < 1.0) || (t.y > 0.0 && t.y < 1.0);
    bool outside = dot(hit.n, hit.p - primitives[4 * i].xyz) > 0.0;
    blocked = blocked || (between && !(i == hit.primitive && outside));
  }
  for (int i = FIRST_MESH; i < FIRST_MESH + N_MESHES; ++i) {
    vec4 instance = primitives[4 * i + 3];
    float t = 1.0;
    int skip = i == hit.primitive ? hit.triangle : -1;
    int triangle = traverse(to_object(i, o, 1.0), to_object(i, to_light, 0.0), t, floatBitsToInt(instance.x),
                            floatBitsToInt(instance.y), true, skip, enabled && !blocked);
    blocked = blocked || triangle >= 0;
  }
  return blocked;
}
