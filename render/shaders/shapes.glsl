// SPDX-License-Identifier: Apache-2.0
// Analytic shapes in forms that survive single precision: the circle equation of Haines, Guenther
// and Akenine-Moeller, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems,
// ch. 7 (2019). The schoolbook quadratic costs 4e-4 rad of phase on a sphere of 5 mm at 250 mm.

// False while a ray starts elsewhere than at the camera's centre or lens.
bool ray_from_camera = true;
bool starts_at_camera() { return BOUNCES == 0 || ray_from_camera; }

struct Hit {
  float t;
  vec3 p;            // camera frame, mm
  vec3 n;            // shading normal, faces the viewer
  vec3 n_geometric;  // of the surface itself, faces the viewer
  vec3 material;     // diffuse, specular, shininess or -alpha
  int primitive;     // -1: nothing
  int triangle;      // meshes
};

// Surfaces closer to each other than 1e-6 of the way to them count as one: the first kind of ANALYTIC_KINDS
// (meshes last), and in it the first listed, is seen. Otherwise rounding would mix them in specks.
#define IN_FRONT 0.999999

const float NO_HIT = -1.0;

struct Roots {
  float near, far;   // NO_HIT where there are none
  vec3 middle;       // of the chord, from the centre (cylinder: from the axis, across it)
  float half_chord;  // in units of d
};

// Roots of |f + t d| = r in any dimension given a = d.d, b = -f.d, the middle f + b/a d of the chord and
// c = f.f - r^2.
Roots circle_roots(float a, float b, vec3 middle, float c, float r) {
  float discriminant = r * r - dot(middle, middle);
  float half_chord = sqrt(max(discriminant, 0.0) / a);
  float q = b + (b < 0.0 ? -1.0 : 1.0) * half_chord * a;
  float t0 = c / q, t1 = q / a;
  bool none = discriminant < 0.0;
  return Roots(none ? NO_HIT : min(t0, t1), none ? NO_HIT : max(t0, t1), middle, half_chord);
}

// Sphere: a centre, radius; b.x |centre|^2 - radius^2 made in double, for rays from the camera (the origin or
// its lens). A normal taken from the middle of the chord is good to the radius, not to the distance.
Roots sphere_roots(const Primitive g, vec3 o, vec3 d, bool from_camera) {
  vec3 f = o - g.a.xyz;
  float a = dot(d, d), b = -dot(f, d);
  vec3 middle = f + (b / a) * d;
  float distance = length(f);
  float c = from_camera ? g.b.x + dot(o, f - g.a.xyz) : (distance - g.a.w) * (distance + g.a.w);
  return circle_roots(a, b, middle, c, g.a.w);
}

void hit_sphere(const Primitive g, vec3 o, vec3 d, inout Hit hit) {
  Roots r = sphere_roots(g, o, d, starts_at_camera());
  if (r.near > 0.0 && r.near < hit.t * IN_FRONT) {
    hit.t = r.near;
    hit.n = (r.middle - r.half_chord * d) / g.a.w;
    hit.material = g.material;
    hit.primitive = g.index;
  }
}

bool sphere_blocks(const Primitive g, const Hit hit, vec3 o, vec3 to_light) {
  Roots t = sphere_roots(g, o, to_light, false);
  return g.index != hit.primitive && ((t.near > 0.0 && t.near < 1.0) || (t.far > 0.0 && t.far < 1.0));
}

// Plane: a normal, normal . point; b u axis, half size; c v axis, half size; d point,
// 1 + place of the albedo map.
float plane_root(const Primitive g, vec3 o, vec3 d) {
  float t = (g.a.w - dot(g.a.xyz, o)) / dot(g.a.xyz, d);
  if (BOUNDED != 0) {
    vec3 p = o + t * d - g.d.xyz;
    if (abs(dot(p, g.b.xyz)) > g.b.w || abs(dot(p, g.c.xyz)) > g.c.w) t = NO_HIT;
  }
  return t;
}

void hit_plane(const Primitive g, vec3 o, vec3 d, inout Hit hit) {
  float t = plane_root(g, o, d);
  if (t > 0.0 && t < hit.t * IN_FRONT) {
    hit.t = t;
    hit.n = g.a.xyz;
    hit.material = g.material;
    hit.primitive = g.index;
  }
}

bool plane_blocks(const Primitive g, const Hit hit, vec3 o, vec3 to_light) {
  float t = plane_root(g, o, to_light);
  return g.index != hit.primitive && t > 0.0 && t < 1.0;
}

// Cylinder: a foot of the perpendicular from the origin to the axis, radius; b axis, half length;
// c.x coordinate of the centre along the axis, c.y |foot|^2 - radius^2.
Roots cylinder_roots(const Primitive g, vec3 o, vec3 d, bool from_camera) {
  vec4 foot = g.a, axis = g.b;
  vec3 d_perp = d - dot(d, axis.xyz) * axis.xyz;
  vec3 o_perp = o - dot(o, axis.xyz) * axis.xyz;
  vec3 f = o_perp - foot.xyz;
  if (!from_camera) f -= dot(f, axis.xyz) * axis.xyz;
  float a = dot(d_perp, d_perp), b = -dot(f, d_perp);
  vec3 middle = f + (b / a) * d_perp;
  float distance = length(f);
  float c = from_camera ? g.c.y + dot(o_perp, f - foot.xyz) : (distance - foot.w) * (distance + foot.w);
  Roots t = circle_roots(a, b, middle, c, foot.w);
  if (BOUNDED != 0) {
    if (abs(dot(o + t.near * d, axis.xyz) - g.c.x) > axis.w) t.near = NO_HIT;
    if (abs(dot(o + t.far * d, axis.xyz) - g.c.x) > axis.w) t.far = NO_HIT;
  }
  return t;
}

void hit_cylinder(const Primitive g, vec3 o, vec3 d, inout Hit hit) {
  Roots r = cylinder_roots(g, o, d, starts_at_camera());
  float t = r.near > 0.0 ? r.near : r.far;
  if (t > 0.0 && t < hit.t * IN_FRONT) {
    hit.t = t;
    vec3 d_perp = d - dot(d, g.b.xyz) * g.b.xyz;
    hit.n = (r.middle + (r.near > 0.0 ? -r.half_chord : r.half_chord) * d_perp) / g.a.w;
    hit.material = g.material;
    hit.primitive = g.index;
  }
}

bool cylinder_blocks(const Primitive g, const Hit hit, vec3 o, vec3 to_light) {
  Roots t = cylinder_roots(g, o, to_light, false);
  bool between = (t.near > 0.0 && t.near < 1.0) || (t.far > 0.0 && t.far < 1.0);
  bool outside = dot(hit.n, hit.p - g.a.xyz) > 0.0;
  return between && !(g.index == hit.primitive && outside);
}

#ifdef PRECISE
// In double the schoolbook forms are good enough: kind_t() computes again where a ray meets the primitive i,
// near the t that was found in single precision. What is fetched goes into a variable before it becomes double:
// NVIDIA's compiler (driver 580.159) makes other numbers of a fetch that is converted at once (tests/house/
// fetched_doubles.py refuses that).
dvec4 exact(int i, int k) {
  int texel = PRIMITIVE_TEXELS * i + k;
  vec4 value = texelFetch(primitive_data, texel), rest = texelFetch(primitive_data, texel + 4);
  return dvec4(value) + dvec4(rest);
}

double nearest_root(dvec3 f, dvec3 d, double r, double t) {
  double a = dot(d, d), b = dot(f, d);
  double root = sqrt(max(b * b - a * (dot(f, f) - r * r), 0.0));
  double t0 = (-b - root) / a, t1 = (-b + root) / a;
  return abs(t0 - t) <= abs(t1 - t) ? t0 : t1;
}

double sphere_t(int i, dvec3 o, dvec3 d, double t) {
  dvec4 a = exact(i, 0);
  return nearest_root(o - a.xyz, d, a.w, t);
}

double plane_t(int i, dvec3 o, dvec3 d, double t) {
  dvec4 a = exact(i, 0);
  return (a.w - dot(a.xyz, o)) / dot(a.xyz, d);
}

double cylinder_t(int i, dvec3 o, dvec3 d, double t) {
  dvec4 a = exact(i, 0);
  dvec3 axis = exact(i, 1).xyz, f = o - a.xyz;
  return nearest_root(f - dot(f, axis) * axis, d - dot(d, axis) * axis, a.w, t);
}
#endif
