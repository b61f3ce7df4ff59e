// SPDX-License-Identifier: Apache-2.0
// Reflection: what of the projected light a hit sends to the camera.

// Walter, Marschner, Li, Torrance, "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007,
// eq. 20, 33, 34: F D G / (4 cos_v), the cosine towards the light included; Schlick's F. G1 and D are
// written without the tangent, D with the sine from a cross product: no cancellation for small alpha.
float ggx_lobe(const Hit hit, vec3 l, vec3 v, float cos_l) {
  float alpha_sq = hit.material.z * hit.material.z;
  vec3 h = l + v;
  h /= sqrt(dot(h, h));
  vec3 across = cross(hit.n, h);
  float cos_v = dot(hit.n, v), cos_h = dot(hit.n, h), grazing = 1.0 - dot(h, l);
  float t = cos_h * cos_h * alpha_sq + dot(across, across);
  float d = alpha_sq / (PI * t * t);
  float g_l = cos_l + sqrt(alpha_sq + (1.0 - alpha_sq) * cos_l * cos_l);
  float g_v = cos_v + sqrt(alpha_sq + (1.0 - alpha_sq) * cos_v * cos_v);
  float g2 = grazing * grazing;
  float f = hit.material.y + (1.0 - hit.material.y) * g2 * g2 * grazing;
  return cos_v > 0.0 && hit.material.y > 0.0 ? f * d * cos_l / (g_l * g_v) : 0.0;
}

// Irradiance per unit pattern value of one hit (paper eq. 6 plus Phong), 0 where unlit.
// `u` = projector coordinate minus the principal point.
float shade(const Hit hit, real3 p, vec3 d, out real2 u, inout uint shadow_rays) {
  vec3 to_light = params.projector_center.xyz - hit.p;
  float distance_sq = dot(to_light, to_light);
  vec3 l = to_light / sqrt(distance_sq);
  float cos_l = dot(hit.n, l);
  bool lit = project(p, u);
  lit = lit && hit.primitive >= 0 && cos_l > 0.0 && dot(hit.n_geometric, l) > 0.0;
  if (SHADOW != 0) {
    shadow_rays += lit ? 1 : 0;
    lit = !occluded(hit, to_light, lit, true) && lit;
  }
  float w = hit.material.x * (1.0 / PI) * cos_l;
  if (SPECULAR != 0) {
    vec3 to_eye = -d / sqrt(dot(d, d));
    bool ggx = (SPECULAR & SPECULAR_GGX) != 0 && hit.material.z < 0.0;
    if ((SPECULAR & SPECULAR_PHONG) != 0) {
      float cos_r = dot(2.0 * cos_l * hit.n - l, to_eye);
      w += cos_r > 0.0 && !ggx ? hit.material.y * pow(cos_r, hit.material.z) : 0.0;
    }
    if ((SPECULAR & SPECULAR_GGX) != 0) w += ggx ? ggx_lobe(hit, l, to_eye, cos_l) : 0.0;
  }
  if (FALLOFF != 0) w *= params.light.x / distance_sq;
  if (PIXEL_GAPS != 0) w *= pixel_gaps(u);
  if (LIGHT_FIELD != 0) w *= light_field(vec2(u));
  return lit ? w * params.projector_center.w : 0.0;
}

// Irradiance that a hit has of the room: ambient light, and that of a far lamp where nothing hides it.
float room_light(const Hit hit, inout uint shadow_rays) {
  vec3 way = params.lamp.xyz, l = way / sqrt(dot(way, way));
  float cos_l = dot(hit.n, l);
  bool lit = hit.primitive >= 0 && cos_l > 0.0 && dot(hit.n_geometric, l) > 0.0;
  if (SHADOW != 0) {
    shadow_rays += lit ? 1 : 0;
    lit = !occluded(hit, way, lit, false) && lit;
  }
  return params.lamp_rest.x + (lit ? params.lamp.w * hit.material.x * cos_l : 0.0);
}
