// SPDX-License-Identifier: Apache-2.0
// A triangle's part of a pixel's square: area, middle and second moments by Green's theorem, summed over the
// parts of the triangle's sides inside the square and of the square's sides inside the triangle. No list of
// corners: indexed arrays are slow on lavapipe.

// The plane through the camera with normal n, as a line in the square: e.xy of unit length, e.xy . p + e.z >= 0
// on the inner side. d0 + du x + dv y is the viewing direction at (x, y).
vec3 line_in_square(vec3 n, vec3 d0, vec3 du, vec3 dv) {
  vec3 e = vec3(dot(du, n), dot(dv, n), dot(d0, n));
  float l = length(e.xy);
  return l > 0.0 ? e / l : vec3(0.0, 0.0, e.z >= 0.0 ? 1e3 : -1e3);
}

float never_zero(float x) { return abs(x) < 1e-12 ? 1e-12 : x; }

// Of p + t dir, the part on the inner side of a line.
void clip_line(vec3 e, vec2 p, vec2 dir, inout float t0, inout float t1) {
  float slope = never_zero(dot(e.xy, dir)), t = -(dot(e.xy, p) + e.z) / slope;
  t0 = slope > 0.0 ? max(t0, t) : t0;
  t1 = slope < 0.0 ? min(t1, t) : t1;
}

// Of the line e, the part within the square and inside of f and g; runs with the inner side to its left.
void clip_side(vec3 e, vec3 f, vec3 g, float h, out vec2 p, out vec2 dir, out float t0, out float t1) {
  p = -e.z * e.xy;
  dir = vec2(e.y, -e.x);
  vec2 inv = 1.0 / vec2(never_zero(dir.x), never_zero(dir.y)), a = (-h - p) * inv, b = (h - p) * inv;
  t0 = max(min(a.x, b.x), min(a.y, b.y));
  t1 = min(max(a.x, b.x), max(a.y, b.y));
  clip_line(f, p, dir, t0, t1);
  clip_line(g, p, dir, t0, t1);
}

bool side_enters(vec3 e, vec3 f, vec3 g, float h) {
  vec2 p, dir;
  float t0, t1;
  clip_side(e, f, g, h, p, dir, t0, t1);
  return t1 > t0;
}

struct Sums {
  vec3 first;   // area, integrals of x and y
  vec3 second;  // of xx, xy, yy
};

void add_stretch(inout Sums sums, vec2 p, vec2 dir, float t0, float t1) {
  vec2 a = p + t0 * dir, b = p + t1 * dir;
  float twice = t1 > t0 ? a.x * b.y - a.y * b.x : 0.0;
  sums.first += twice * vec3(0.5, (a + b) / 6.0);
  sums.second += (twice / 24.0) * vec3(2.0 * (a.x * a.x + a.x * b.x + b.x * b.x),
                                       2.0 * (a.x * a.y + b.x * b.y) + a.x * b.y + b.x * a.y,
                                       2.0 * (a.y * a.y + a.y * b.y + b.y * b.y));
}

struct Piece {
  float area;
  vec2 middle;
  vec2 long_axis, short_axis;  // sqrt 2 of its standard deviations
};

Piece clip_to_square(vec3 e0, vec3 e1, vec3 e2, float h) {
  Sums sums = Sums(vec3(0.0), vec3(0.0));
  vec2 p, dir;
  float t0, t1;
#define ADD_SIDE(e, f, g)                  \
  clip_side(e, f, g, h, p, dir, t0, t1);   \
  add_stretch(sums, p, dir, t0, t1);
  ADD_SIDE(e0, e1, e2)
  ADD_SIDE(e1, e2, e0)
  ADD_SIDE(e2, e0, e1)
#define ADD_BORDER(from, along)            \
  t0 = 0.0;                                \
  t1 = 2.0 * h;                            \
  clip_line(e0, from, along, t0, t1);      \
  clip_line(e1, from, along, t0, t1);      \
  clip_line(e2, from, along, t0, t1);      \
  add_stretch(sums, from, along, t0, t1);
  ADD_BORDER(vec2(-h, -h), vec2(1.0, 0.0))
  ADD_BORDER(vec2(h, -h), vec2(0.0, 1.0))
  ADD_BORDER(vec2(h, h), vec2(-1.0, 0.0))
  ADD_BORDER(vec2(-h, h), vec2(0.0, -1.0))

  Piece piece;
  bool some = sums.first.x > 1e-9;
  piece.area = some ? sums.first.x : 0.0;
  float inv = some ? 1.0 / sums.first.x : 0.0;
  vec2 c = sums.first.yz * inv;
  piece.middle = c;
  vec3 m = sums.second * inv - vec3(c.x * c.x, c.x * c.y, c.y * c.y);
  float mean = 0.5 * (m.x + m.z), half_difference = 0.5 * (m.x - m.z);
  float spread = length(vec2(half_difference, m.y));
  vec2 axis = half_difference >= 0.0 ? vec2(half_difference + spread, m.y) : vec2(m.y, spread - half_difference);
  float l = length(axis);
  axis = l > 0.0 ? axis / l : vec2(1.0, 0.0);
  piece.long_axis = sqrt(max(2.0 * (mean + spread), 0.0)) * axis;
  piece.short_axis = sqrt(max(2.0 * (mean - spread), 0.0)) * vec2(-axis.y, axis.x);
  return piece;
}

// Four points of equal weight that integrate second-order polynomials over the piece exactly.
vec2 rule_point(const Piece piece, int j) {
  vec2 step = j < 2 ? piece.long_axis : piece.short_axis;
  return piece.middle + ((j & 1) != 0 ? -step : step);
}
