// SPDX-License-Identifier: Apache-2.0
// A triangle's part of a pixel's square: area, middle, second and third moments by Green's theorem, summed over the
// parts of the triangle's sides inside the square and of the square's sides inside the triangle. No list of
// corners: indexed arrays are slow on lavapipe.

// The plane through the camera with normal n, as a line in the square: e.xy of unit length, e.xy . p + e.z >= 0
// on the inner side. d0 + du x + dv y is the viewing direction at (x, y).
vec3 line_in_square(vec3 n, vec3 d0, vec3 du, vec3 dv) {
  vec3 e = vec3(dot(du, n), dot(dv, n), dot(d0, n));
  float l = length(e.xy);
  return l > 0.0 ? e / l : vec3(0.0, 0.0, e.z >= 0.0 ? 1e3 : -1e3);
}

// The same line seen from another point of the square.
vec3 moved_line(vec3 e, vec2 center) { return vec3(e.xy, e.z + dot(e.xy, center)); }

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
  vec4 third;   // of xxx, xxy, xyy, yyy
};

void add_stretch(inout Sums sums, vec2 p, vec2 dir, float t0, float t1) {
  vec2 a = p + t0 * dir, b = p + t1 * dir;
  float twice = t1 > t0 ? a.x * b.y - a.y * b.x : 0.0;
  sums.first += twice * vec3(0.5, (a + b) / 6.0);
  sums.second += (twice / 24.0) * vec3(2.0 * (a.x * a.x + a.x * b.x + b.x * b.x),
                                       2.0 * (a.x * a.y + b.x * b.y) + a.x * b.y + b.x * a.y,
                                       2.0 * (a.y * a.y + a.y * b.y + b.y * b.y));
  vec2 aa = a * a, ab = a * b, bb = b * b;
  sums.third += (twice / 60.0) * vec4(3.0 * (aa.x + bb.x) * (a.x + b.x),
                                      a.y * (3.0 * aa.x + 2.0 * ab.x + bb.x) + b.y * (aa.x + 2.0 * ab.x + 3.0 * bb.x),
                                      a.x * (3.0 * aa.y + 2.0 * ab.y + bb.y) + b.x * (aa.y + 2.0 * ab.y + 3.0 * bb.y),
                                      3.0 * (aa.y + bb.y) * (a.y + b.y));
}

struct Piece {
  float area;
  vec2 middle;
  vec2 long_axis, short_axis;  // sqrt 2 of its standard deviations
  vec2 skew;                   // along them, as rule_point takes it
  vec2 cross_third;            // third moments long-long-short and long-short-short, in units of the axes
};

// Half the skewness of two points that carry half the weight. A triangle's is the largest of a convex piece: 2 sqrt(2)/5;
// more is rounding.
vec2 rule_skew(vec2 third, vec2 variance) { return clamp(0.3535533906 * third * inversesqrt(max(variance * variance * variance, vec2(1e-30))), vec2(-0.2), vec2(0.2)); }

Piece clip_to_square(vec3 e0, vec3 e1, vec3 e2, float h) {
  Sums sums = Sums(vec3(0.0), vec3(0.0), vec4(0.0));
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
  // Differences of products near h^2 are good to 1e-8 or so: less is no piece, and what is little is kept in the square.
  bool some = sums.first.x > 4e-7 * h * h;
  piece.area = some ? sums.first.x : 0.0;
  float inv = some ? 1.0 / sums.first.x : 0.0;
  vec2 c = clamp(sums.first.yz * inv, vec2(-h), vec2(h));
  piece.middle = c;
  vec3 m = sums.second * inv - vec3(c.x * c.x, c.x * c.y, c.y * c.y);
  float mean = 0.5 * (m.x + m.z), half_difference = 0.5 * (m.x - m.z);
  float spread = length(vec2(half_difference, m.y));
  vec2 axis = half_difference >= 0.0 ? vec2(half_difference + spread, m.y) : vec2(m.y, spread - half_difference);
  float l = length(axis);
  axis = l > 0.0 ? axis / l : vec2(1.0, 0.0);
  vec2 s = vec2(-axis.y, axis.x), variance = clamp(vec2(mean + spread, mean - spread), vec2(0.0), vec2(h * h));
  piece.long_axis = sqrt(2.0 * variance.x) * axis;
  piece.short_axis = sqrt(2.0 * variance.y) * s;
  // About the middle, and turned into the axes.
  vec4 t = sums.third * inv;
  t -= vec4(c.x * (3.0 * m.x + c.x * c.x), c.y * (m.x + c.x * c.x) + 2.0 * c.x * m.y, c.x * (m.z + c.y * c.y) + 2.0 * c.y * m.y,
            c.y * (3.0 * m.z + c.y * c.y));
  vec2 l2 = axis * axis, s2 = s * s;
  vec4 turned = vec4(axis.x * l2.x * t.x + 3.0 * (l2.x * axis.y * t.y + axis.x * l2.y * t.z) + axis.y * l2.y * t.w,
                     l2.x * s.x * t.x + (l2.x * s.y + 2.0 * axis.x * axis.y * s.x) * t.y + (l2.y * s.x + 2.0 * axis.x * axis.y * s.y) * t.z + l2.y * s.y * t.w,
                     s2.x * axis.x * t.x + (s2.x * axis.y + 2.0 * s.x * s.y * axis.x) * t.y + (s2.y * axis.x + 2.0 * s.x * s.y * axis.y) * t.z + s2.y * axis.y * t.w,
                     s.x * s2.x * t.x + 3.0 * (s2.x * s.y * t.y + s.x * s2.y * t.z) + s.y * s2.y * t.w);
  piece.skew = rule_skew(turned.xw, variance);
  vec2 lengths = max(sqrt(2.0 * variance), vec2(1e-12));
  piece.cross_third = clamp(turned.yz / (lengths.x * lengths.y * lengths), vec2(-0.42), vec2(0.42));
  return piece;
}

// Nine points that integrate polynomials of third order over the piece exactly, and most of the fourth's mixed part:
// on each axis the nodes h - r, 0, h + r with r = sqrt(1 + h^2). Weights (h + r, 0, r - h)/(4 r) of the outer ones have
// the axis' variance and skewness; what the axes have in common comes by divided differences.
vec3 rule_nodes(float h) { return vec3(h - sqrt(1.0 + h * h), 0.0, h + sqrt(1.0 + h * h)); }
vec3 half_second_difference(float h) {
  vec3 x = rule_nodes(h);
  return vec3(x.z, x.x - x.z, -x.x) / (x.z - x.x);
}
vec3 first_difference(float h) {
  vec3 x = rule_nodes(h);
  return vec3(-x.z * x.z, 2.0 * h * (x.z - x.x), x.x * x.x) / (x.z - x.x);
}

// Point n of 9, row by row along the long axis; its weight is of the piece's area. Four fifths of the variances' product
// are what the mixed fourth moment is on average over triangles in a square.
vec2 rule_point(const Piece piece, int n, out float weight) {
  int i = n % 3, k = n / 3;
  float second_long = half_second_difference(piece.skew.x)[i], second_short = half_second_difference(piece.skew.y)[k];
  weight = piece.cross_third.x * second_long * first_difference(piece.skew.y)[k] +
           piece.cross_third.y * first_difference(piece.skew.x)[i] * second_short + 0.2 * second_long * second_short;
  weight += i != 1 && k == 1 ? 0.5 * second_long : i == 1 && k != 1 ? 0.5 * second_short : 0.0;
  return piece.middle + rule_nodes(piece.skew.x)[i] * piece.long_axis + rule_nodes(piece.skew.y)[k] * piece.short_axis;
}
