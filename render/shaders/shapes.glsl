// SPDX-License-Identifier: Apache-2.0
// Analytic shapes in forms that survive single precision: the circle equation of Haines, Guenther
// and Akenine-Moeller, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems,
// ch. 7 (2019). The schoolbook quadratic costs 4e-4 rad of phase on a sphere of 5 mm at 250 mm.

const float NO_HIT = -1.0;

// Roots of |f + t d| = r in any dimension given a = d.d, b = -f.d, the squared distance of the line
// from the centre and c = f.f - r^2. (NO_HIT, NO_HIT) if there are none.
vec2 circle_roots(float a, float b, float line_distance_sq, float c, float r) {
  float discriminant = r * r - line_distance_sq;
  float q = b + (b < 0.0 ? -1.0 : 1.0) * sqrt(a * max(discriminant, 0.0));
  float t0 = c / q, t1 = q / a;
  return discriminant < 0.0 ? vec2(NO_HIT) : vec2(min(t0, t1), max(t0, t1));
}

// Sphere: a centre, radius; b.x |centre|^2 - radius^2 made in double for rays from the origin.
vec2 sphere_roots(const Primitive g, vec3 o, vec3 d, bool from_origin) {
  vec3 f = o - g.a.xyz;
  float a = dot(d, d), b = -dot(f, d);
  vec3 l = f + (b / a) * d;
  float distance = length(f);
  float c = from_origin ? g.b.x : (distance - g.a.w) * (distance + g.a.w);
  return circle_roots(a, b, dot(l, l), c, g.a.w);
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
vec2 cylinder_roots(const Primitive g, vec3 o, vec3 d, bool from_origin) {
  vec4 foot = g.a, axis = g.b;
  vec3 d_perp = d - dot(d, axis.xyz) * axis.xyz;
  vec3 f = o - foot.xyz;
  f -= dot(f, axis.xyz) * axis.xyz;
  float a = dot(d_perp, d_perp), b = -dot(f, d_perp);
  vec3 l = f + (b / a) * d_perp;
  float distance = length(f);
  float c = from_origin ? g.c.y : (distance - foot.w) * (distance + foot.w);
  vec2 t = circle_roots(a, b, dot(l, l), c, foot.w);
  if (BOUNDED != 0) {
    if (abs(dot(o + t.x * d, axis.xyz) - g.c.x) > axis.w) t.x = NO_HIT;
    if (abs(dot(o + t.y * d, axis.xyz) - g.c.x) > axis.w) t.y = NO_HIT;
  }
  return t;
}
