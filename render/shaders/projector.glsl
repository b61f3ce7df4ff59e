// SPDX-License-Identifier: Apache-2.0
// Radius of the projector's circle of confusion at the point last projected, over its depth: times
// the focal length (px) the radius in its image.
float defocus = 0.0;

// Point in the camera frame -> projector coordinate minus the principal point. Measured from there
// the coordinate is small near the axis and its rounding error, too. False: no light (behind the
// projector, beyond the lens's invertible radius, or more than half a pixel outside its image).
bool project(real3 p, out real2 u) {
  real4 x = real4(p, 1.0);
  real z = dot(REAL_PARAM(projector_r2), x);
  real2 a = real2(dot(REAL_PARAM(projector_r0), x), dot(REAL_PARAM(projector_r1), x)) / z;
  real r2 = dot(a, a);
  bool valid = z > 0.0 && r2 <= params.projector_f.z;
  if (PROJECTOR == PROJECTOR_OPENCV5 || PROJECTOR == PROJECTOR_OPENCV12) {
    real4 k = REAL_PARAM(projector_k0), k1 = REAL_PARAM(projector_k1);
    real radial = 1.0 + r2 * (k.x + r2 * (k.y + r2 * k1.x));
    if (PROJECTOR == PROJECTOR_OPENCV12) radial /= 1.0 + r2 * (k1.y + r2 * (k1.z + r2 * k1.w));
    real2 b = a * radial + real2(2.0 * k.z * a.x * a.y + k.w * (r2 + 2.0 * a.x * a.x),
                               k.z * (r2 + 2.0 * a.y * a.y) + 2.0 * k.w * a.x * a.y);
    if (PROJECTOR == PROJECTOR_OPENCV12) {
      real4 k2 = REAL_PARAM(projector_k2);
      b += r2 * (k2.xz + r2 * k2.yw);
    }
    a = b;
  }
  u = a * REAL_PARAM(projector_f).xy;
  if (PROJECTOR == PROJECTOR_GRID) {
    vec2 g = (vec2(a) - params.projector_grid.xy) * params.projector_grid.zw;
    ivec2 n = ivec2(params.projector_grid_n.xy);
    valid = valid && all(greaterThanEqual(g, vec2(0.0))) && all(lessThanEqual(g, vec2(n - 1)));
    ivec2 node = clamp(ivec2(floor(valid ? g : vec2(0.0))), ivec2(1), n - 3);
    vec4 wx, wy, unused1, unused2;
    lagrange4(g.x - float(node.x), wx, unused1, unused2);
    lagrange4(g.y - float(node.y), wy, unused1, unused2);
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i)
        u += real2(wy[j] * wx[i] * texelFetch(projector_grid, (node.y - 1 + j) * n.x + node.x - 1 + i).xy);
  }
  if (DEFOCUS != 0)
    defocus = z > 1e-3 ? params.projector_optics.x * abs(1.0 / float(z) - params.projector_optics.y) : 0.0;
  vec4 e = params.projector_edge;
  return valid && u.x >= e.x && u.x < e.y && u.y >= e.z && u.y < e.w;
}

float waveform(int first, float position) {
  float base = floor(position);
  int i = first + int(base);
  return mix(texelFetch(waveforms, i).x, texelFetch(waveforms, i + 1).x, position - base);
}

// The dark gaps between the projector's pixels: factor of everything projected, with mean 1. Blurred it
// is a table of one pixel's width from its left border, the first of the pass's tables.
float pixel_gaps(real2 u) {
  float n = params.projector_gaps.x, fill = params.projector_gaps.y;
  vec2 t = vec2(fract(u + REAL_PARAM(projector_gaps).zw));
  if (PIXEL_GAPS == PIXEL_GAPS_SHARP)
    return all(lessThanEqual(abs(t - 0.5), vec2(0.5 * fill))) ? 1.0 / (fill * fill) : 0.0;
  return waveform(0, t.x * n) * waveform(0, t.y * n);
}

// Light at u over its geometric mean in the projector's image: exp of Legendre's products.
float light_field(vec2 u) {
  vec4 edge = params.projector_edge, a = params.light_field_0, b = params.light_field_1, c = params.light_field_2;
  vec2 p1 = (2.0 * u - (edge.xz + edge.yw)) / (edge.yw - edge.xz), s = p1 * p1;
  vec2 p2 = 1.5 * s - 0.5, p3 = p1 * (2.5 * s - 1.5), p4 = (4.375 * s - 3.75) * s + 0.375;
  float first = a.x * p1.x + a.y * p1.y, second = a.z * p2.x + a.w * p1.x * p1.y + b.x * p2.y;
  float third = b.y * p3.x + b.z * p2.x * p1.y + b.w * p1.x * p2.y + c.x * p3.y;
  float fourth = c.y * p4.x + c.z * p3.x * p1.y + c.w * p2.x * p2.y;
  fourth += params.light_field_3.x * p1.x * p3.y + params.light_field_3.y * p4.y;
  return exp(first + second + third + fourth);
}
