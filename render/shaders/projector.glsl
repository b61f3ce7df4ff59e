// SPDX-License-Identifier: Apache-2.0
// Point in the camera frame -> projector coordinate minus the principal point. Measured from there
// the coordinate is small near the axis and its rounding error, too. False: no light (behind the
// projector, beyond the lens's invertible radius, or more than half a pixel outside its image).
bool project(vec3 p, out vec2 u) {
  vec4 x = vec4(p, 1.0);
  float z = dot(params.projector_r2, x);
  vec2 a = vec2(dot(params.projector_r0, x), dot(params.projector_r1, x)) / z;
  float r2 = dot(a, a);
  bool valid = z > 0.0 && r2 <= params.projector_f.z;
  if (PROJECTOR == PROJECTOR_OPENCV5 || PROJECTOR == PROJECTOR_OPENCV12) {
    vec4 k = params.projector_k0, k1 = params.projector_k1;
    float radial = 1.0 + r2 * (k.x + r2 * (k.y + r2 * k1.x));
    if (PROJECTOR == PROJECTOR_OPENCV12) radial /= 1.0 + r2 * (k1.y + r2 * (k1.z + r2 * k1.w));
    vec2 b = a * radial + vec2(2.0 * k.z * a.x * a.y + k.w * (r2 + 2.0 * a.x * a.x),
                               k.z * (r2 + 2.0 * a.y * a.y) + 2.0 * k.w * a.x * a.y);
    if (PROJECTOR == PROJECTOR_OPENCV12) b += r2 * (params.projector_k2.xz + r2 * params.projector_k2.yw);
    a = b;
  }
  u = a * params.projector_f.xy;
  if (PROJECTOR == PROJECTOR_GRID) {
    vec2 g = (a - params.projector_grid.xy) * params.projector_grid.zw;
    ivec2 n = ivec2(params.projector_grid_n.xy);
    valid = valid && all(greaterThanEqual(g, vec2(0.0))) && all(lessThanEqual(g, vec2(n - 1)));
    ivec2 node = clamp(ivec2(floor(valid ? g : vec2(0.0))), ivec2(1), n - 3);
    vec4 wx, wy, unused1, unused2;
    lagrange4(g.x - float(node.x), wx, unused1, unused2);
    lagrange4(g.y - float(node.y), wy, unused1, unused2);
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i)
        u += wy[j] * wx[i] * texelFetch(projector_grid, (node.y - 1 + j) * n.x + node.x - 1 + i).xy;
  }
  vec4 e = params.projector_edge;
  return valid && u.x >= e.x && u.x < e.y && u.y >= e.z && u.y < e.w;
}
