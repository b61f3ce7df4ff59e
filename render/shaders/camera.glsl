// SPDX-License-Identifier: Apache-2.0
// Pixel -> ray direction. The lens was inverted on the CPU in double at the nodes of a coarse grid;
// here its residual against the plain pinhole (or, for wide lenses, the unit direction itself) is
// interpolated by 4-point Lagrange polynomials once per pixel, with first and second derivatives
// for the samples inside the pixel. The table is in single precision also where rays are double: a
// residual of 0.02 rounds to 1e-9, the components of a wide lens's direction to 3e-8 (5e-6 rad of phase
// on the paper's rig).

struct PixelRays {
  real2 pinhole;  // (q - c) / f; 0 for wide lenses
  vec3 d, du, dv, duu, duv, dvv;
};

// Weights of the 4 nodes -1, 0, 1, 2 at s, and their first and second derivatives.
void lagrange4(float s, out vec4 w, out vec4 w1, out vec4 w2) {
  float s2 = s * s, s3 = s2 * s;
  w = vec4((-s3 + 3.0 * s2 - 2.0 * s) / 6.0, (s3 - 2.0 * s2 - s + 2.0) / 2.0, (-s3 + s2 + 2.0 * s) / 2.0,
           (s3 - s) / 6.0);
  w1 = vec4((-3.0 * s2 + 6.0 * s - 2.0) / 6.0, (3.0 * s2 - 4.0 * s - 1.0) / 2.0,
            (-3.0 * s2 + 2.0 * s + 2.0) / 2.0, (3.0 * s2 - 1.0) / 6.0);
  w2 = vec4(1.0 - s, 3.0 * s - 2.0, 1.0 - 3.0 * s, s);
}

PixelRays pixel_rays(vec2 q) {
  PixelRays r;
  real4 c = REAL_PARAM(camera);
  r.pinhole = CAMERA == CAMERA_GENERAL ? real2(0.0) : (real2(q) - c.zw) * c.xy;
  r.d = r.du = r.dv = r.duu = r.duv = r.dvv = vec3(0.0);
  if (CAMERA == CAMERA_PINHOLE) return r;

  vec2 g = (q - params.lens_grid.xy) * params.lens_grid.zw;
  ivec2 n = ivec2(params.lens_grid_n.xy);
  ivec2 node = clamp(ivec2(floor(g)), ivec2(1), n - 3);  // one-sided at the borders
  vec4 wx, wx1, wx2, wy, wy1, wy2;
  lagrange4(g.x - float(node.x), wx, wx1, wx2);
  lagrange4(g.y - float(node.y), wy, wy1, wy2);
  vec3 f = vec3(0.0), fx = vec3(0.0), fy = vec3(0.0), fxx = vec3(0.0), fxy = vec3(0.0), fyy = vec3(0.0);
  int first = (node.y - 1) * n.x + node.x - 1;
#define LENS_ROW(j)                                        \
  {                                                        \
    vec3 a = texelFetch(lens_grid, first + j * n.x).xyz;     \
    vec3 b = texelFetch(lens_grid, first + j * n.x + 1).xyz; \
    vec3 c = texelFetch(lens_grid, first + j * n.x + 2).xyz; \
    vec3 e = texelFetch(lens_grid, first + j * n.x + 3).xyz; \
    vec3 row = wx.x * a + wx.y * b + wx.z * c + wx.w * e;      \
    vec3 row1 = wx1.x * a + wx1.y * b + wx1.z * c + wx1.w * e; \
    vec3 row2 = wx2.x * a + wx2.y * b + wx2.z * c + wx2.w * e; \
    f += wy[j] * row;                                        \
    fx += wy[j] * row1;                                      \
    fy += wy1[j] * row;                                      \
    fxx += wy[j] * row2;                                     \
    fxy += wy1[j] * row1;                                    \
    fyy += wy2[j] * row;                                     \
  }
  LENS_ROW(0) LENS_ROW(1) LENS_ROW(2) LENS_ROW(3)
#undef LENS_ROW
  vec2 k = params.lens_grid.zw;
  if (CAMERA == CAMERA_PERSPECTIVE) {
    r.d.xy = f.xy;
    r.du.xy = fx.xy * k.x;
    r.dv.xy = fy.xy * k.y;
    r.duu.xy = fxx.xy * (k.x * k.x);
    r.duv.xy = fxy.xy * (k.x * k.y);
    r.dvv.xy = fyy.xy * (k.y * k.y);
  } else {
    r.d = f;
    r.du = fx * k.x;
    r.dv = fy * k.y;
    r.duu = fxx * (k.x * k.x);
    r.duv = fxy * (k.x * k.y);
    r.dvv = fyy * (k.y * k.y);
  }
  return r;
}

// `offset` from the pixel centre, px. Not normalised (z = 1 for perspective lenses).
real3 ray_direction(const PixelRays r, vec2 offset) {
  vec3 d = vec3(0.0);
  if (CAMERA != CAMERA_PINHOLE)
    d = r.d + r.du * offset.x + r.dv * offset.y + r.duu * (0.5 * offset.x * offset.x) +
        r.duv * (offset.x * offset.y) + r.dvv * (0.5 * offset.y * offset.y);
  if (CAMERA == CAMERA_GENERAL) return real3(d);
  return real3(r.pinhole + real2(offset) * REAL_PARAM(camera).xy + real2(d.xy), 1.0);
}

// Derivative of ray_direction along x (axis 0) or y at the pixel's centre, per px.
real3 direction_per_px(const PixelRays r, int axis) {
  real3 d = real3(axis == 0 ? r.du : r.dv);
  if (CAMERA != CAMERA_GENERAL) {
    real4 c = REAL_PARAM(camera);
    d += axis == 0 ? real3(c.x, 0.0, 0.0) : real3(0.0, c.y, 0.0);
  }
  return d;
}
