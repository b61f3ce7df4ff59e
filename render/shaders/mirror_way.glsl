// SPDX-License-Identifier: Apache-2.0
// Ways of the projector's light to a place over a shiny surface: the direction in which the surface mirrors the
// projector, and how fast its normal and the bisector of light and viewer part beside it. Where their difference
// follows the lobe's distribution of slopes, directions do: they are taken with that density.

struct MirrorWay {
  vec3 d;           // unit vector
  float alpha;      // GGX's, of the surface; 0: there is no way
  vec4 turns;       // slope x and y per step along t and b of basis(d) at unit distance
};

MirrorWay load_way(uint slot, uint k) {
  uint at = WAY_TEXELS * (MIRROR_WAYS * slot + k);
  vec4 first = ways[at];
  return MirrorWay(first.xyz, first.w, ways[at + 1u]);
}

void store_way(uint slot, uint k, const MirrorWay way) {
  uint at = WAY_TEXELS * (MIRROR_WAYS * slot + k);
  ways[at] = vec4(way.d, way.alpha);
  ways[at + 1u] = way.turns;
}

float turned_area(const MirrorWay way) { return way.turns.x * way.turns.w - way.turns.y * way.turns.z; }

// The direction of a point of a unit square.
vec3 along_way(vec2 v, const MirrorWay way) {
  vec3 t, b;
  basis(way.d, t, b);
  float radius = way.alpha * sqrt(v.x / max(1.0 - v.x, 1e-6));
  vec2 slope = radius * vec2(cos(TWO_PI * v.y), sin(TWO_PI * v.y));
  vec2 step_ = vec2(way.turns.w * slope.x - way.turns.y * slope.y, way.turns.x * slope.y - way.turns.z * slope.x);
  step_ /= way.alpha > 0.0 ? turned_area(way) : 1.0;
  return normalize(way.d + step_.x * t + step_.y * b);
}

// Their density per steradian.
float way_density(vec3 d, const MirrorWay way) {
  vec3 t, b;
  basis(way.d, t, b);
  float along = dot(d, way.d), far = 1.0 / max(along, 1e-3), alpha_sq = way.alpha * way.alpha;
  vec2 step_ = far * vec2(dot(d, t), dot(d, b));
  vec2 slope = vec2(way.turns.x * step_.x + way.turns.y * step_.y, way.turns.z * step_.x + way.turns.w * step_.y);
  float spread = alpha_sq + dot(slope, slope);
  bool there = along > 1e-3 && way.alpha > 0.0;
  return there ? alpha_sq / (PI * spread * spread) * abs(turned_area(way)) * far * far * far : 0.0;
}

// GGX's alpha of a hit's lobe; of Phong's one as wide.
float alpha_of(const Hit hit) {
  return hit.material.z < 0.0 ? -hit.material.z : min(1.0, inversesqrt(2.0 * max(hit.material.z, 0.5)));
}

// By how much the bisector of the ways to the projector and back along d is off a hit's normal; some length that
// no bisector has where the hit mirrors nothing.
vec3 off_mirror(const Hit hit, vec3 d) {
  vec3 to_light = params.projector_center.xyz - hit.p, l = to_light / sqrt(dot(to_light, to_light)), h = l - d;
  float length_sq = dot(h, h);
  bool mirrors = hit.primitive >= 0 && dot(hit.n, l) > 0.0 && length_sq > 1e-6;
  return mirrors ? h / sqrt(length_sq) - hit.n : vec3(4.0);
}
bool mirrors(vec3 off) { return off.x < 3.0; }
