// SPDX-License-Identifier: Apache-2.0
// Reflection: what of the projected light a hit sends to the camera.

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
    lit = !occluded(hit, to_light, lit) && lit;
  }
  float w = hit.material.x * (1.0 / PI) * cos_l;
  if (SPECULAR != 0) {
    vec3 to_eye = -d / sqrt(dot(d, d));
    float cos_r = dot(2.0 * cos_l * hit.n - l, to_eye);
    w += cos_r > 0.0 ? hit.material.y * pow(cos_r, hit.material.z) : 0.0;
  }
  if (FALLOFF != 0) w *= params.light.x / distance_sq;
  return lit ? w * params.projector_center.w : 0.0;
}
