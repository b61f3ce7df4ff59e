// SPDX-License-Identifier: Apache-2.0
// The hit point in the precision of `real`: found in single precision, in the PRECISE variant computed
// again in double on the shape that was found.
#ifndef PRECISE
real3 refined_point(const Hit hit, real3 o, real3 d) { return hit.p; }
#else

dvec4 exact(int i, int k) {
  int texel = PRIMITIVE_TEXELS * i + k;
  return dvec4(texelFetch(primitive_data, texel)) + dvec4(texelFetch(primitive_data, texel + 4));
}

// The root of |f + t d| = r nearest to the one found in single precision. In double the schoolbook
// quadratic is good enough.
double nearest_root(dvec3 f, dvec3 d, double r, double t) {
  double a = dot(d, d), b = dot(f, d);
  double root = sqrt(max(b * b - a * (dot(f, f) - r * r), 0.0));
  double t0 = (-b - root) / a, t1 = (-b + root) / a;
  return abs(t0 - t) <= abs(t1 - t) ? t0 : t1;
}

double triangle_t(const Hit hit, int i, dvec3 o, dvec3 d) {
  dvec4 rows[3] = dvec4[3](exact(i, 0), exact(i, 1), exact(i, 2));
  dvec3 o_object = dvec3(dot(rows[0], dvec4(o, 1.0)), dot(rows[1], dvec4(o, 1.0)), dot(rows[2], dvec4(o, 1.0)));
  dvec3 d_object = dvec3(dot(rows[0].xyz, d), dot(rows[1].xyz, d), dot(rows[2].xyz, d));
  int k = 3 * (int(texelFetch(primitive_data, PRIMITIVE_TEXELS * i + 3).y) + max(hit.triangle, 0));
  dvec3 v0 = dvec3(FETCH_TRIANGLE(k).xyz);
  dvec3 n = cross(dvec3(FETCH_TRIANGLE(k + 1).xyz) - v0, dvec3(FETCH_TRIANGLE(k + 2).xyz) - v0);
  double slope = dot(n, d_object);
  return slope != 0.0 ? dot(n, v0 - o_object) / slope : double(hit.t);  // edge-on
}

real3 refined_point(const Hit hit, real3 o, real3 d) {
  if (N_SPHERES + N_PLANES + N_CYLINDERS + N_MESHES == 0) return hit.p;
  int i = max(hit.primitive, 0);
  double t = double(hit.t);
  dvec4 a = exact(i, 0);
  if (N_SPHERES > 0 && i < FIRST_PLANE) t = nearest_root(o - a.xyz, d, a.w, t);
  if (N_PLANES > 0 && i >= FIRST_PLANE && i < FIRST_CYLINDER) t = (a.w - dot(a.xyz, o)) / dot(a.xyz, d);
  if (N_CYLINDERS > 0 && i >= FIRST_CYLINDER && i < FIRST_MESH) {
    dvec3 axis = exact(i, 1).xyz, f = o - a.xyz;
    t = nearest_root(f - dot(f, axis) * axis, d - dot(d, axis) * axis, a.w, t);
  }
  if (N_MESHES > 0 && i >= FIRST_MESH) t = triangle_t(hit, i, o, d);
  return hit.primitive < 0 ? dvec3(hit.p) : o + t * d;
}
#endif
