// SPDX-License-Identifier: Apache-2.0
// The hit point in the precision of `real`: found in single precision, in the PRECISE variant computed
// again in double on the shape that was found.
#ifndef PRECISE
real3 refined_point(const Hit hit, real3 o, real3 d) { return hit.p; }
#else

double triangle_t(const Hit hit, int i, dvec3 o, dvec3 d) {
  dvec4 rows[3] = dvec4[3](exact(i, 0), exact(i, 1), exact(i, 2));
  dvec3 o_object = dvec3(dot(rows[0], dvec4(o, 1.0)), dot(rows[1], dvec4(o, 1.0)), dot(rows[2], dvec4(o, 1.0)));
  dvec3 d_object = dvec3(dot(rows[0].xyz, d), dot(rows[1].xyz, d), dot(rows[2].xyz, d));
  int k = 3 * (int(texelFetch(primitive_data, PRIMITIVE_TEXELS * i + 3).y) + max(hit.triangle, 0));
  vec4 corner0 = FETCH_TRIANGLE(k), corner1 = FETCH_TRIANGLE(k + 1), corner2 = FETCH_TRIANGLE(k + 2);
  dvec3 v0 = dvec3(corner0.xyz);
  dvec3 n = cross(dvec3(corner1.xyz) - v0, dvec3(corner2.xyz) - v0);
  double slope = dot(n, d_object);
  return slope != 0.0 ? dot(n, v0 - o_object) / slope : double(hit.t);  // edge-on
}

real3 refined_point(const Hit hit, real3 o, real3 d) {
  if (FIRST_MESH + N_MESHES == 0) return hit.p;
  int i = max(hit.primitive, 0);
  double t = double(hit.t);
#define REFINE(number, KIND, kind, first) \
  if (N_##KIND > 0 && i >= FIRST_##KIND && i < FIRST_##KIND + N_##KIND) t = kind##_t(i, o, d, t);
  ANALYTIC_KINDS(REFINE)
  if (N_MESHES > 0 && i >= FIRST_MESH) t = triangle_t(hit, i, o, d);
  return hit.primitive < 0 ? dvec3(hit.p) : o + t * d;
}
#endif
