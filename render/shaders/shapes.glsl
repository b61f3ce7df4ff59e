// SPDX-License-Identifier: Apache-2.0
// Analytic shapes in forms that survive single precision: the circle equation of Haines, Guenther
// and Akenine-Moeller, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems,
// ch. 7 (2019). The schoolbook quadratic costs 4e-4 rad of phase on a sphere of 5 mm at 250 mm.

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
