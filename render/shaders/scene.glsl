// SPDX-License-Identifier: Apache-2.0
// Nearest hit over all objects, and whether the projector sees a point.

// Everything about the hit of a given triangle, in front of the ray or not. `within`: the ray is known to
// meet the triangle itself, not only its plane.
void complete_mesh_hit(const Primitive g, vec3 o, vec3 d, int triangle, bool found, bool within, inout Hit hit) {
  vec3 o_object = to_object(g, o, 1.0), d_object = to_object(g, d, 0.0);
  int k = 3 * (int(g.d.y) + max(triangle, 0));
  vec4 a0 = FETCH_TRIANGLE(k), a1 = FETCH_TRIANGLE(k + 1), a2 = FETCH_TRIANGLE(k + 2);
  vec3 v0 = a0.xyz - o_object, v1 = a1.xyz - o_object, v2 = a2.xyz - o_object;
  vec3 n = vec3(a0.w, a1.w, a2.w);  // unit normal, made in double
  Along along = along_ray(d_object);
  // The plane form is more accurate than the test's t, except edge-on: never beyond the corners' depths.
  float t0 = dot(along.t, v0), t1 = dot(along.t, v1), t2 = dot(along.t, v2);
  float low = min(t0, min(t1, t2)), high = max(t0, max(t1, t2));
  float slope = dot(n, d_object);
  float t = slope != 0.0 ? dot(n, v0) / slope : low;
  if (within) t = clamp(t, low, high);
  vec3 n_geometric = direction_from_object(g, n);
  vec3 n_shading = n_geometric;
  vec3 material = g.material;
  if (CORNERS != 0) {
    vec3 e = edge_functions(along, v0, v1, v2);
    e /= e.x + e.y + e.z;
    int c = 3 * (int(g.d.y) + max(triangle, 0));
    vec4 corner = e.x * FETCH_CORNER(c) + e.y * FETCH_CORNER(c + 1) + e.z * FETCH_CORNER(c + 2);
    int flags = int(g.d.w);
    float length_sq = dot(corner.xyz, corner.xyz);  // ~0 where triangles of both windings meet
    if ((flags & MESH_SMOOTH) != 0 && length_sq > 1e-6)
      n_shading = direction_from_object(g, corner.xyz / sqrt(length_sq));
    if ((flags & MESH_ALBEDO) != 0) material.x *= corner.w;
  }
  if (found) {
    hit.t = t;
    // A facet wound the other way round has its neighbours' vertex normals.
    hit.n = dot(n_shading, n_geometric) < 0.0 ? -n_shading : n_shading;
    hit.n_geometric = n_geometric;
    hit.material = material;
    hit.primitive = g.index;
    hit.triangle = triangle;
  }
}

// Where walks through the first mesh start: near the pixel, then where the ray before ended.
int start_triangle = -1;
int start_tile = 0;

void start_walks(uvec2 pixel) {
  if ((LINKS & LINKS_WALK) == 0) return;
  start_tile = int((pixel.y >> params.starts.x) * params.starts.y + (pixel.x >> params.starts.x));
  start_triangle = texelFetch(start_tiles, start_tile).x;
}

void hit_mesh(const Primitive g, vec3 o, vec3 d, inout Hit hit) {
  float t = hit.t * IN_FRONT;
  vec3 o_object = to_object(g, o, 1.0), d_object = to_object(g, d, 0.0);
  int walked = -1;
  bool settled = false;
  if ((LINKS & LINKS_WALK) != 0) {
    int start = start_triangle;
    if (N_MESHES > 1)
      start = texelFetch(start_tiles, start_tile + (g.index - FIRST_MESH) * int(params.starts.z)).x;
    walked = walk(o_object, d_object, t, int(g.d.y), int(g.d.z), starts_at_camera() ? start : -1, settled);
  }
  int triangle = traverse(o_object, d_object, t, int(g.d.x), int(g.d.y), false, -1, !settled);
  triangle = settled ? walked : triangle;
  if (triangle >= 0) start_triangle = triangle;
  complete_mesh_hit(g, o, d, triangle, triangle >= 0, true, hit);
}

float map_texel(int first, ivec2 size, ivec2 at) {
  at = clamp(at, ivec2(0), size - 1);
  return texelFetch(waveforms, first + 2 + at.y * size.x + at.x).x;
}

// Albedo map of a plane: pixels are squares, bilinear between their centres, the border continued.
float map_albedo(const Hit hit) {
  bool on_plane = hit.primitive >= FIRST_PLANES && hit.primitive < FIRST_PLANES + N_PLANES;
  int k = PRIMITIVE_TEXELS * (on_plane ? hit.primitive : 0);
  vec4 u = texelFetch(primitive_data, k + 1), v = texelFetch(primitive_data, k + 2);
  vec4 point = texelFetch(primitive_data, k + 3);
  bool has_map = on_plane && point.w > 0.0;
  int first = int(params.light.w) + (has_map ? int(point.w) - 1 : 0);
  ivec2 size = has_map ? ivec2(int(texelFetch(waveforms, first).x), int(texelFetch(waveforms, first + 1).x)) : ivec2(1);
  vec3 r = hit.p - point.xyz;
  vec2 q = (0.5 + 0.5 * vec2(dot(r, u.xyz) / u.w, dot(r, v.xyz) / v.w)) * vec2(size) - 0.5;
  q = has_map ? q : vec2(0.0);
  ivec2 i = ivec2(floor(q));
  vec2 s = q - floor(q);
  float a = mix(mix(map_texel(first, size, i), map_texel(first, size, i + ivec2(1, 0)), s.x),
                mix(map_texel(first, size, i + ivec2(0, 1)), map_texel(first, size, i + ivec2(1, 1)), s.x), s.y);
  return has_map ? a : 1.0;
}

Hit no_hit() {
  Hit hit;
  hit.t = INFINITY_T;
  hit.n = vec3(0.0, 0.0, -1.0);
  hit.n_geometric = hit.n;
  hit.material = vec3(0.0, 0.0, 1.0);
  hit.primitive = -1;
  hit.triangle = -1;
  return hit;
}

void place_hit(vec3 o, vec3 d, inout Hit hit) {
  hit.p = o + hit.t * d;
  if (hit.primitive < 0) hit.p = vec3(0.0, 0.0, -1.0);
  if (dot(hit.n_geometric, d) > 0.0) {
    hit.n_geometric = -hit.n_geometric;
    hit.n = -hit.n;
  }
}

Hit closest_hit(vec3 o, vec3 d) {
  Hit hit = no_hit();
#define HIT(kind, g) hit_##kind(g, o, d, hit)
#define HIT_KIND(number, KIND, kind, first) FOR_EACH(KIND, kind, HIT)
  ANALYTIC_KINDS(HIT_KIND)
  hit.n_geometric = hit.n;
  if (N_MESHES > 0) hit_mesh(instance, o, d, hit);
  if (N_MESHES > 1)
    for (int i = FIRST_MESH + 1; i < FIRST_MESH + N_MESHES; ++i) hit_mesh(fetch_primitive(i), o, d, hit);
  place_hit(o, d, hit);
  if (ALBEDO_MAPS != 0) hit.material.x *= map_albedo(hit);
  return hit;
}

bool mesh_blocks(const Primitive g, const Hit hit, vec3 o, vec3 to_light, bool enabled, bool linked_light) {
  float t = 1.0;
  bool own = g.index == hit.primitive;
  int skip = own ? hit.triangle : -1;
  if ((LINKS & LINKS_SHADOW) != 0 && linked_light)
    enabled = enabled && !(own && (FETCH_LINK(int(g.d.z) + max(hit.triangle, 0)).w & LINK_LIT) != 0);
  return traverse(to_object(g, o, 1.0), to_object(g, to_light, 0.0), t, int(g.d.x),
                  int(g.d.y), true, skip, enabled) >= 0;
}

// Is anything between the hit and the light at hit.p + to_light? Only asked for points
// whose lit side is seen, so a sphere, a plane or the outside of a cylinder cannot hide itself.
// `linked_light`: it is the projector, of which the links between triangles know.
bool occluded(const Hit hit, vec3 to_light, bool enabled, bool linked_light) {
  vec3 o = hit.p + hit.n_geometric * (params.light.y * max(max(abs(hit.p.x), abs(hit.p.y)), abs(hit.p.z)));
  bool blocked = false;
#define BLOCK(kind, g) blocked = kind##_blocks(g, hit, o, to_light) || blocked
#define BLOCK_KIND(number, KIND, kind, first) FOR_EACH(KIND, kind, BLOCK)
  ANALYTIC_KINDS(BLOCK_KIND)
  if (N_MESHES > 0) blocked = mesh_blocks(instance, hit, o, to_light, enabled && !blocked, linked_light) || blocked;
  if (N_MESHES > 1)
    for (int i = FIRST_MESH + 1; i < FIRST_MESH + N_MESHES; ++i)
      blocked = mesh_blocks(fetch_primitive(i), hit, o, to_light, enabled && !blocked, linked_light) || blocked;
  return blocked;
}
