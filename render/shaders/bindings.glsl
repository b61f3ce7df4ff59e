// SPDX-License-Identifier: Apache-2.0
// Buffers and switches of the trace kernel.
#extension GL_EXT_samplerless_texture_functions : require
#include "shared.h"

// The variant PRECISE carries everything that decides the phase in double: rays, hit points (refined
// after a search in single precision), projection, pattern coordinates. It leaves 2e-7 rad of rounding on
// spheres, 3e-6 behind a distorted lens over a whole frame and 5e-6 behind a wide one (their tables are
// single, camera.glsl), where single precision leaves 1.5e-5 ... 3.5e-5, and costs about twice the time.
#ifdef PRECISE
#define real double
#define real2 dvec2
#define real3 dvec3
#define real4 dvec4
#define REAL_PARAM(member) (dvec4(params.member) + dvec4(params_rest.member))
#else
#define real float
#define real2 vec2
#define real3 vec3
#define real4 vec4
#define REAL_PARAM(member) params.member
#endif

#define PI 3.14159265358979
#define TWO_PI 6.28318530717959
#define INFINITY_T 3.0e38

#define DECLARE_CONSTANT(number, name, otherwise, value) layout(constant_id = number) const int name = otherwise;
#define DECLARE_COUNT(number, KIND, kind, first) DECLARE_CONSTANT(number, N_##KIND, 0, 0)
ANALYTIC_KINDS(DECLARE_COUNT)
SPECIALISATION_CONSTANTS(DECLARE_CONSTANT)
#ifdef WITHOUT_SHADOW  // of a kernel that shades what is known to be lit, whatever the host says
#define SHADOW 0
#endif
// A function: glslang joins constants by && and ?: into modules that are not valid.
bool linked(int bit) { return (LINKS & bit) != 0; }

#define DECLARE_FIRST(number, KIND, kind, first) const int FIRST_##KIND = first;
#define PLUS_COUNT(number, KIND, kind, first) + N_##KIND
ANALYTIC_KINDS(DECLARE_FIRST)
const int FIRST_MESH = ANALYTIC_KINDS(PLUS_COUNT);
const int N_TABLES = N_PERIODIC + N_AXIS;
const int FIRST_IMAGE = N_TABLES + N_PIXEL + N_GRAY;
const int N_DIRECT = FIRST_IMAGE + N_IMAGES;

layout(push_constant) uniform PushBlock { Push push; };
layout(std140, binding = BIND_PARAMS) uniform ParamsBlock {
  Params values;
  Params rest;  // what rounding to float left of each value
} params_block;
layout(binding = BIND_PRIMITIVES) uniform textureBuffer primitive_data;
layout(binding = BIND_MATERIALS) uniform textureBuffer material_data;

// lavapipe reads uniform buffers lane by lane, even at constant offsets: everything the sample loop
// needs is copied here once per pixel (4 times faster on a plane). Unused members cost nothing.
Params params, params_rest;

struct Primitive {
  vec4 a, b, c, d;
  vec3 material;  // diffuse, specular, shininess or -alpha
  int index;
};
#define KEPT 3  // primitives of each kind read once per pixel; the others in the loops
#define DECLARE_KEPT(number, KIND, kind, first) Primitive kept_##kind[KEPT];
ANALYTIC_KINDS(DECLARE_KEPT)
Primitive instance;

Primitive fetch_primitive(int i) {
  int k = PRIMITIVE_TEXELS * i;
  return Primitive(texelFetch(primitive_data, k), texelFetch(primitive_data, k + 1), texelFetch(primitive_data, k + 2),
                   texelFetch(primitive_data, k + 3), texelFetch(material_data, i).xyz, i);
}

void load_constants() {
  params = params_block.values;
  params_rest = params_block.rest;
#define LOAD_KEPT(number, KIND, kind, first)                            \
  if (N_##KIND > 0) kept_##kind[0] = fetch_primitive(FIRST_##KIND);     \
  if (N_##KIND > 1) kept_##kind[1] = fetch_primitive(FIRST_##KIND + 1); \
  if (N_##KIND > 2) kept_##kind[2] = fetch_primitive(FIRST_##KIND + 2);
  ANALYTIC_KINDS(LOAD_KEPT)
  if (N_MESHES > 0) instance = fetch_primitive(FIRST_MESH);
}

// CALL(kind, primitive) for all of a kind, the kept ones with constant indices.
#define FOR_EACH(KIND, kind, CALL)              \
  if (N_##KIND > 0) CALL(kind, kept_##kind[0]); \
  if (N_##KIND > 1) CALL(kind, kept_##kind[1]); \
  if (N_##KIND > 2) CALL(kind, kept_##kind[2]); \
  if (N_##KIND > 3)                             \
    for (int i = FIRST_##KIND + 3; i < FIRST_##KIND + N_##KIND; ++i) CALL(kind, fetch_primitive(i));

// On lavapipe 22.3 a uniform texel buffer is 7 times faster than a storage buffer; devices whose
// texel buffers are too small for the mesh get the storage variant.
#ifdef GEOMETRY_STORAGE
layout(std430, binding = BIND_NODES) readonly buffer NodesBlock { ivec4 node_data[]; };
layout(std430, binding = BIND_TRIANGLES) readonly buffer TrianglesBlock { vec4 triangle_data[]; };
layout(std430, binding = BIND_CORNERS) readonly buffer CornersBlock { vec4 corner_data[]; };
layout(std430, binding = BIND_LINKS) readonly buffer LinksBlock { ivec4 link_data[]; };
#define FETCH_LINK(i) link_data[i]
#define FETCH_NODE(i) node_data[i]
#define FETCH_TRIANGLE(i) triangle_data[i]
#define FETCH_CORNER(i) corner_data[i]
#else
layout(binding = BIND_NODES) uniform itextureBuffer node_data;
layout(binding = BIND_TRIANGLES) uniform textureBuffer triangle_data;
layout(binding = BIND_CORNERS) uniform textureBuffer corner_data;
layout(binding = BIND_LINKS) uniform itextureBuffer link_data;
#define FETCH_LINK(i) texelFetch(link_data, i)
#define FETCH_NODE(i) texelFetch(node_data, i)
#define FETCH_TRIANGLE(i) texelFetch(triangle_data, i)
#define FETCH_CORNER(i) texelFetch(corner_data, i)
#endif

layout(binding = BIND_STARTS) uniform itextureBuffer start_tiles;
layout(binding = BIND_LENS_GRID) uniform textureBuffer lens_grid;
layout(binding = BIND_PROJECTOR_GRID) uniform textureBuffer projector_grid;
layout(binding = BIND_SAMPLES) uniform textureBuffer sample_table;
layout(binding = BIND_SOBOL) uniform utextureBuffer sobol_table;
layout(binding = BIND_WAVEFORMS) uniform textureBuffer waveforms;
layout(binding = BIND_BLOCKS) uniform utextureBuffer block_list;
layout(binding = BIND_PIXELS) uniform utextureBuffer pixel_list;
layout(binding = BIND_PROBE) uniform textureBuffer probe;
layout(std430, binding = BIND_PROBE_OUT) writeonly buffer ProbeBlock { vec4 probe_out[]; };
layout(binding = BIND_POINTS) uniform textureBuffer gather_points;
layout(std430, binding = BIND_PLACES) writeonly buffer PlacesBlock { vec4 places_out[]; };
layout(binding = BIND_CELL_TABLE) uniform utextureBuffer cell_table;
layout(binding = BIND_CELL_LIGHT) uniform textureBuffer cell_light;
layout(binding = BIND_MIRRORS) uniform textureBuffer mirror_places;
layout(std430, binding = BIND_WAYS) buffer WaysBlock { vec4 ways[]; };
layout(std430, binding = BIND_OUTPUT) buffer OutputBlock { float sums[]; };
layout(std430, binding = BIND_OBJECTS) writeonly buffer ObjectsBlock { int objects[]; };
layout(std430, binding = BIND_STATUS) buffer StatusBlock { uint status[]; };

// Runs F(0) ... F(15); with a constant condition inside F nothing is left of the unused ones. Written
// out, because constant indices keep the arrays in registers on every driver.
#define REPEAT8(F) F(0) F(1) F(2) F(3) F(4) F(5) F(6) F(7)
#define REPEAT16(F) REPEAT8(F) F(8) F(9) F(10) F(11) F(12) F(13) F(14) F(15)
#define REPEAT16_ON(F) \
  F(16) F(17) F(18) F(19) F(20) F(21) F(22) F(23) F(24) F(25) F(26) F(27) F(28) F(29) F(30) F(31)
#define REPEAT32(F) REPEAT16(F) REPEAT16_ON(F)
