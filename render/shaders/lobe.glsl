// SPDX-License-Identifier: Apache-2.0
// Directions from which a place's own lobe takes light that it sends to the camera. `eye`: unit vector towards it.

float ggx_masking(float cosine, float alpha_sq) {
  return 2.0 * cosine / (cosine + sqrt(alpha_sq + (1.0 - alpha_sq) * cosine * cosine));
}

// Heitz, "Sampling the GGX Distribution of Visible Normals", JCGT 7(4), 2018.
vec3 ggx_direction(vec2 v, const Hit hit, vec3 eye, vec3 t, vec3 b) {
  float alpha = -hit.material.z;
  vec3 e = vec3(dot(t, eye), dot(b, eye), max(dot(hit.n, eye), 1e-4));
  vec3 stretched = normalize(vec3(alpha * e.xy, e.z));
  float across_sq = dot(stretched.xy, stretched.xy);
  vec3 t1 = across_sq > 0.0 ? vec3(-stretched.y, stretched.x, 0.0) / sqrt(across_sq) : vec3(1.0, 0.0, 0.0);
  vec3 t2 = cross(stretched, t1);
  float r = sqrt(v.x), x = r * cos(TWO_PI * v.y), y = r * sin(TWO_PI * v.y);
  y = mix(sqrt(max(0.0, 1.0 - x * x)), y, 0.5 + 0.5 * stretched.z);
  vec3 up = x * t1 + y * t2 + sqrt(max(0.0, 1.0 - x * x - y * y)) * stretched;
  vec3 h = normalize(vec3(alpha * up.xy, max(up.z, 1e-7)));
  vec3 l = 2.0 * dot(e, h) * h - e;
  return l.x * t + l.y * b + l.z * hit.n;
}

// A power of the cosine around the mirrored direction to the camera.
vec3 phong_direction(vec2 v, const Hit hit, vec3 eye) {
  vec3 axis = 2.0 * dot(hit.n, eye) * hit.n - eye, t, b;
  basis(axis, t, b);
  float c = pow(max(v.x, 1e-7), 1.0 / (max(hit.material.z, 0.0) + 1.0)), s = sqrt(max(0.0, 1.0 - c * c));
  return s * cos(TWO_PI * v.y) * t + s * sin(TWO_PI * v.y) * b + c * axis;
}

bool has_ggx(const Hit hit) { return (SPECULAR & SPECULAR_GGX) != 0 && hit.material.z < 0.0; }

// The direction of a point of a unit square.
vec3 lobe_direction(vec2 v, const Hit hit, vec3 eye, vec3 t, vec3 b) {
  vec3 d = hit.n;
  if ((SPECULAR & SPECULAR_PHONG) != 0) d = phong_direction(v, hit, eye);
  if ((SPECULAR & SPECULAR_GGX) != 0 && has_ggx(hit)) d = ggx_direction(v, hit, eye, t, b);
  return d;
}

// The share of the radiance from a direction that the lobe sends to the camera, per steradian (the cosine
// included), and the density of the directions above.
vec2 lobe_and_density(vec3 d, const Hit hit, vec3 eye) {
  float cos_l = dot(d, hit.n), cos_v = max(dot(hit.n, eye), 1e-4);
  vec2 out_ = vec2(0.0);
  if ((SPECULAR & SPECULAR_PHONG) != 0) {
    float power = max(hit.material.z, 0.0), c = dot(2.0 * dot(hit.n, eye) * hit.n - eye, d);
    float lobe = c > 0.0 ? pow(c, power) : 0.0;
    out_ = lobe * vec2(hit.material.y, (power + 1.0) / TWO_PI);
  }
  if ((SPECULAR & SPECULAR_GGX) != 0) {
    vec3 h = normalize(d + eye), across = cross(hit.n, h);
    float alpha_sq = hit.material.z * hit.material.z, cos_h = dot(hit.n, h);
    float spread = cos_h * cos_h * alpha_sq + dot(across, across);
    float density = alpha_sq / (PI * spread * spread) * ggx_masking(cos_v, alpha_sq) / (4.0 * cos_v);
    if (has_ggx(hit)) out_ = vec2(ggx_lobe(hit, d, eye, max(cos_l, 0.0)), density);
  }
  return cos_l > 0.0 ? out_ : vec2(0.0);
}
