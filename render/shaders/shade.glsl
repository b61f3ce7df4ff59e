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

// Of what shade() returned last, the share that the lobe reflects.
float share_of_lobe = 0.0;

// Orthonormal basis: Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
void basis(vec3 n, out vec3 t, out vec3 b) {
  float s = n.z >= 0.0 ? 1.0 : -1.0, a = -1.0 / (s + n.z), c = n.x * n.y * a;
  t = vec3(1.0 + s * n.x * n.x * a, s * c, -s * n.x);
  b = vec3(c, s + n.y * n.y * a, -n.y);
}

// Half of what the projector's coordinates change from one side of a place to the other.
vec2 px_beside(real3 p, vec3 side) {
  real2 before, after;
  project(p - real3(side), before);
  project(p + real3(side), after);
  return 0.5 * vec2(after - before);
}

// Sets what the light that a lit hit sends to the camera along v has been through. Its light comes along -l; `share`:
// of it that is reflected by the diffuse law.
void set_below(const Hit hit, real3 p, vec3 l, vec3 v, float share, bool lit) {
  const float STEP = 0.25;  // of the mean free path, to both sides
  float path_mm = texelFetch(material_data, FIRST_MESH + N_MESHES + max(hit.primitive, 0)).x;
  float step_mm = max(STEP * path_mm, 1e-3), kept = defocus;
  vec3 t, b;
  basis(hit.n_geometric, t, b);
  vec2 per_t = px_beside(p, step_mm * t) * (path_mm / step_mm), per_b = px_beside(p, step_mm * b) * (path_mm / step_mm);
  defocus = kept;
  float all = abs(per_t.x) + abs(per_t.y) + abs(per_b.x) + abs(per_b.y);
  bool goes_in = lit && path_mm > 0.0 && all < 1e4;  // not beyond the projector's horizon, and no NaN
  vec2 light = vec2(dot(t, l), dot(b, l)) / REFRACTION, viewer = vec2(dot(t, v), dot(b, v)) / REFRACTION;
  float s = scattering_of_albedo(hit.material.x);
  below.spread_px2 = vec3(per_t.x * per_t.x + per_b.x * per_b.x, per_t.x * per_t.y + per_b.x * per_b.y,
                          per_t.y * per_t.y + per_b.y * per_b.y);
  below.light_px = per_t * light.x + per_b * light.y;
  below.viewer_px = per_t * viewer.x + per_b * viewer.y;
  below.cosines = sqrt(1.0 - vec2(dot(light, light), dot(viewer, viewer)));
  below.lost = 3.0 * s * s;
  below.share = share;
  below.scale = profile_scale(hit.material.x);
  if (!goes_in) below = NEVER_BELOW;
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
  float w = hit.material.x * (1.0 / PI) * cos_l, diffuse = w;
  vec3 to_eye = -d / sqrt(dot(d, d));
  if (SPECULAR != 0) {
    bool ggx = (SPECULAR & SPECULAR_GGX) != 0 && hit.material.z < 0.0;
    if ((SPECULAR & SPECULAR_PHONG) != 0) {
      float cos_r = dot(2.0 * cos_l * hit.n - l, to_eye);
      w += cos_r > 0.0 && !ggx ? hit.material.y * pow(cos_r, hit.material.z) : 0.0;
    }
    if ((SPECULAR & SPECULAR_GGX) != 0) w += ggx ? ggx_lobe(hit, l, to_eye, cos_l) : 0.0;
  }
  if (GLOSSY != 0) share_of_lobe = w > 0.0 ? 1.0 - diffuse / w : 0.0;
  if (SUBSURFACE != 0) set_below(hit, p, l, to_eye, w > 0.0 ? diffuse / w : 0.0, lit);
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
