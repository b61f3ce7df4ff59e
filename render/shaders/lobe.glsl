// SPDX-License-Identifier: Apache-2.0
// Directions from which a place's own lobe takes light that it sends to the camera.

// A direction, what its radiance counts (the lobe's share of it over the density), and its density per steradian.
struct LobeDirection {
  vec3 d;
  float share, density;
};

float ggx_masking(float cosine, float alpha_sq) {
  return 2.0 * cosine / (cosine + sqrt(alpha_sq + (1.0 - alpha_sq) * cosine * cosine));
}

// Heitz, "Sampling the GGX Distribution of Visible Normals", JCGT 7(4), 2018: with separate masking of both sides
// the lobe over its density is Fresnel's factor times the masking of the light.
LobeDirection ggx_direction(vec2 v, const Hit hit, vec3 eye, vec3 t, vec3 b) {
  float alpha = -hit.material.z, alpha_sq = alpha * alpha;
  vec3 e = vec3(dot(t, eye), dot(b, eye), dot(hit.n, eye));
  vec3 stretched = normalize(vec3(alpha * e.xy, max(e.z, 1e-4)));
  float across_sq = dot(stretched.xy, stretched.xy);
  vec3 t1 = across_sq > 0.0 ? vec3(-stretched.y, stretched.x, 0.0) / sqrt(across_sq) : vec3(1.0, 0.0, 0.0);
  vec3 t2 = cross(stretched, t1);
  float r = sqrt(v.x), x = r * cos(TWO_PI * v.y), y = r * sin(TWO_PI * v.y), half_up = 0.5 + 0.5 * stretched.z;
  y = mix(sqrt(max(0.0, 1.0 - x * x)), y, half_up);
  vec3 up = x * t1 + y * t2 + sqrt(max(0.0, 1.0 - x * x - y * y)) * stretched;
  vec3 h = normalize(vec3(alpha * up.xy, max(up.z, 1e-7)));
  float along = dot(e, h);
  vec3 l = 2.0 * along * h - e;
  float grazing = 1.0 - along, g2 = grazing * grazing;
  float fresnel = hit.material.y + (1.0 - hit.material.y) * g2 * g2 * grazing;
  float spread = h.z * h.z * alpha_sq + dot(h.xy, h.xy);
  LobeDirection from;
  from.d = l.x * t + l.y * b + l.z * hit.n;
  from.share = l.z > 0.0 && e.z > 0.0 ? fresnel * ggx_masking(l.z, alpha_sq) : 0.0;
  from.density = alpha_sq / (PI * spread * spread) * ggx_masking(max(e.z, 1e-4), alpha_sq) / (4.0 * max(e.z, 1e-4));
  return from;
}

// A power of the cosine around the mirrored direction to the camera.
LobeDirection phong_direction(vec2 v, const Hit hit, vec3 eye) {
  float power = hit.material.z;
  vec3 axis = 2.0 * dot(hit.n, eye) * hit.n - eye, t, b;
  basis(axis, t, b);
  float c = pow(max(v.x, 1e-7), 1.0 / (power + 1.0)), s = sqrt(max(0.0, 1.0 - c * c));
  LobeDirection from;
  from.d = s * cos(TWO_PI * v.y) * t + s * sin(TWO_PI * v.y) * b + c * axis;
  from.share = dot(from.d, hit.n) > 0.0 ? hit.material.y * TWO_PI / (power + 1.0) : 0.0;
  from.density = (power + 1.0) / TWO_PI * pow(c, power);
  return from;
}

LobeDirection lobe_direction(vec2 v, const Hit hit, vec3 eye, vec3 t, vec3 b) {
  bool ggx = (SPECULAR & SPECULAR_GGX) != 0 && hit.material.z < 0.0;
  LobeDirection from = LobeDirection(hit.n, 0.0, 1.0);
  if ((SPECULAR & SPECULAR_PHONG) != 0) from = phong_direction(v, hit, eye);
  if ((SPECULAR & SPECULAR_GGX) != 0 && ggx) from = ggx_direction(v, hit, eye, t, b);
  if (hit.material.y == 0.0) from.share = 0.0;
  return from;
}
