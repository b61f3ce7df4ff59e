// SPDX-License-Identifier: Apache-2.0
// What a ray saw, as one number: 0 nothing; else 1 + the place of its surface in a list of all analytic
// primitives and all triangles of all mesh instances, negative where no projected light arrives. A float,
// exact below 2^24 (checked on the host). material_data.w holds the first place of each primitive.

float identity(const Hit hit, float w) {
  if (hit.primitive < 0) return 0.0;
  float place = texelFetch(material_data, hit.primitive).w + 1.0 + float(max(hit.triangle, 0));
  return w > 0.0 ? place : -place;
}

int primitive_of(float id) {
  int place = int(abs(id)) - 1;
  if (N_MESHES == 0) return place;
  int primitive = min(place, FIRST_MESH);
  for (int i = FIRST_MESH + 1; i < FIRST_MESH + N_MESHES; ++i)
    primitive = place >= int(texelFetch(material_data, i).w) ? i : primitive;
  return primitive;
}

int triangle_of(float id, int primitive) { return int(abs(id)) - 1 - int(texelFetch(material_data, primitive).w); }

vec4 probe_at(ivec2 pixel) { return texelFetch(probe, pixel.y * int(params.image.x) + pixel.x); }
bool in_image(ivec2 pixel) {
  return pixel.x >= 0 && pixel.y >= 0 && pixel.x < int(params.image.x) && pixel.y < int(params.image.y);
}

// Of the finest fringe in a pixel, rad: sixteenths of the pixel serve facets up to there (facets.comp).
const float MOST_FACET_SWING = 6.0;
