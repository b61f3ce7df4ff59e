// SPDX-License-Identifier: Apache-2.0
// Layouts and numbers shared by the C++ host and the GLSL shaders. Only 16-byte members, so that
// std140 and C++ agree by construction; the static_asserts at the end say so.
#ifndef FRINGETWIN_SHADERS_SHARED_H
#define FRINGETWIN_SHADERS_SHARED_H

#ifdef __cplusplus
#include <cstddef>
#include <cstdint>
namespace fringetwin::render::gpu {
using uint = std::uint32_t;
struct vec4 {
  float x = 0, y = 0, z = 0, w = 0;
};
struct uvec4 {
  uint x = 0, y = 0, z = 0, w = 0;
};
#endif

// ---- sizes
#define BLOCK_WIDTH 32
#define BLOCK_HEIGHT 8
#define BLOCK_PIXELS 256
#define PRIMITIVE_TEXELS 8
#define MAX_PITCHES 32  // cosine/sine pairs in one pass: one per pitch and harmonic
#define MAX_DIRECT 16  // directly evaluated images in one pass
#define MOST_COLUMNS 16  // of a Gauss rule
#define STACK_SIZE 32
#define SENTINEL_LOOPS 3
#define LINES_PER_PANEL 4   // scan lines of one invocation group over a mixed pixel

// ---- bindings (set 0)
#define BIND_PARAMS 0
#define BIND_PRIMITIVES 1  // 4 x vec4 each, then what rounding to float left of them
#define BIND_MATERIALS 2   // diffuse, specular, shininess or -alpha (GGX), first surface; then, with SUBSURFACE,
                           // per primitive mean free path mm, 0, 0, 0
#define BIND_NODES 3       // BVH nodes, 4 x ivec4 each
#define BIND_TRIANGLES 4   // 3 x vec4 vertices each
#define BIND_CORNERS 5     // 3 x vec4 (normal, albedo) each
#define BIND_LENS_GRID 6
#define BIND_PROJECTOR_GRID 7
// Gauss: vec4 (dx, dy, weight, column + MOST_COLUMNS row), with a lens (x, y, 0, 0) after each; then per
// column (= row) the two ends of its share of the pixel, as seen from the sample.
#define BIND_SAMPLES 8
#define BIND_SOBOL 9    // uvec4, four dimensions of 32 bits
#define BIND_WAVEFORMS 10
#define BIND_BLOCKS 11  // x | y << 16, in blocks
#define BIND_OUTPUT 12  // [channel][block][pixel]
#define BIND_OBJECTS 13
#define BIND_STATUS 14  // [0] truncated invocations, [1] shadow rays
#define BIND_PIXELS 15  // list of pixels: x | y << 15 | scan along y << 31
#define BIND_PROBE 16   // what the centre rays saw, one texel per pixel: u (2), w, identity (identity.glsl);
                        // then, with SUBSURFACE, PROBE_MORE texels per pixel: Below (subsurface.glsl)
#define BIND_PROBE_OUT 17
#define BIND_LINKS 18      // per triangle of each mesh instance: neighbours opposite its corners, LINK_ bits
#define BIND_STARTS 19     // per mesh instance and tile of pixels: a triangle near by, -1 none
#define BIND_POINTS 20     // of gather.comp: position and seed, shading normal, normal
#define BIND_PLACES 21     // what pixels see, or per point and direction what is met: as the points, with numbers
#define BIND_CELL_TABLE 22 // key and number of each cell, by the hash of the key
#define BIND_CELL_LIGHT 23 // per cell: mean, (cosine, sine) per pair, direct images
#define BIND_WAYS 24       // per place: MIRROR_WAYS ways of WAY_TEXELS vec4 each, mirror_ways.glsl
#define BIND_MIRRORS 25    // places of shiny surfaces: position and primitive, normal
#define BIND_COUNT 26

// ---- kinds of analytic primitives: X(number of the constant N_KIND, KIND, kind, index of the first). All primitives
// of a kind follow one another, the mesh instances come last. shapes.glsl has hit_kind(), kind_blocks() and kind_t().
#define ANALYTIC_KINDS(X) \
  X(0, SPHERES, sphere, 0) \
  X(1, PLANES, plane, FIRST_SPHERES + N_SPHERES) \
  X(2, CYLINDERS, cylinder, FIRST_PLANES + N_PLANES)

// ---- the other specialisation constants: X(number, name, default, value). NAME in the shaders (bindings.glsl),
// SPEC_NAME in C++, where make_constants() (trace/shader_params.cpp) takes the value.
#define SPECIALISATION_CONSTANTS(X) \
  X(3, N_MESHES, 0, scene.count[KIND_MESHES]) \
  X(4, SHADOW, 0, scene.shadow) \
  X(5, SPECULAR, 0, scene.specular) \
  X(6, LENS_DISK, 0, camera.optics.has_value()) /* depth of field */ \
  X(7, FALLOFF, 0, projector.inverse_square) \
  X(8, BOUNDED, 0, scene.bounded) /* any plane or cylinder with an end */ \
  X(9, CAMERA, 0, lens.kind) \
  X(10, PROJECTOR, 0, setup.kind) \
  X(11, SAMPLER, 0, samples.kind) \
  X(12, CORNERS, 0, scene.corners) /* any mesh with vertex normals or albedo */ \
  X(13, N_PITCHES, 0, pass.pitches.size()) \
  X(14, N_PERIODIC, 0, pass.count(DirectSlot::Kind::periodic)) \
  X(15, N_AXIS, 0, pass.count(DirectSlot::Kind::axis)) \
  X(16, N_GRAY, 0, pass.count(DirectSlot::Kind::gray)) \
  X(17, GRAY_BLUR, 0, projector.least_blur_px() > 0.0 || !scene.below_surfaces.empty()) /* Gaussian edges of Gray images */ \
  X(18, N_IMAGES, 0, pass.count(DirectSlot::Kind::image)) \
  X(19, PIXEL_LIST, 0, 0) /* pixels from the list instead of whole blocks: set per dispatch */ \
  X(20, FUNDAMENTALS, -1, pass.fundamentals()) /* bit i: pair i starts a pitch; the others are the next harmonic of the pair before */ \
  X(21, DEFOCUS, 0, projector.optics.has_value()) /* of the projector */ \
  X(22, PIXEL_GAPS, 0, pixel_gaps(projector, pass)) \
  X(23, N_PIXEL, 0, pass.count(DirectSlot::Kind::pixel)) \
  X(24, ALBEDO_MAPS, 0, !scene.maps.empty()) \
  X(25, BOUNCES, 0, 0) /* rays that leave surfaces, too: set by who uses the kernel that has them */ \
  X(26, LINKS, 0, links) /* LINKS_ bits */ \
  X(27, BLUR_FIELD, 0, projector.has_blur_field()) /* the blur varies over the projector's image */ \
  X(28, LIGHT_FIELD, 0, projector.has_light_field()) /* and so does the light */ \
  X(29, LAMP, 0, twin.room.has_lamp()) /* room light from a direction */ \
  X(30, MORE_BOUNCES, 0, cells.has_value()) /* light that has come over two surfaces and more */ \
  X(31, WRITE_PLACES, 0, 0) /* what each direction meets: set by who uses it */ \
  X(32, SUBSURFACE, 0, !scene.below_surfaces.empty()) /* light that goes below surfaces */ \
  X(33, GLOSSY, 0, 0) /* light between surfaces leaves them by their lobes, too: set by who uses it */ \
  X(34, BY_LOBE, 0, 0) /* what a place's own lobe sends to the camera is gathered: the same */ \
  X(35, N_WAYS, 0, 0) /* directions along ways of mirrored light besides: MIRROR_WAYS or none, the same */

#define CAMERA_PINHOLE 0      // ((q - c) / f, 1)
#define CAMERA_PERSPECTIVE 1  // + residual grid (2 components)
#define CAMERA_GENERAL 2      // direction grid (3 components)
#define PROJECTOR_PINHOLE 0
#define PROJECTOR_OPENCV5 1   // k1 k2 p1 p2 k3
#define PROJECTOR_OPENCV12 2  // + rational and thin prism terms
#define PROJECTOR_GRID 3      // residual grid over (x/z, y/z)
#define SAMPLER_TABLE 0
#define SAMPLER_MULTI_JITTERED 1
#define SAMPLER_SOBOL 2
#define SAMPLER_MULTI_JITTERED_ANY 3

// ---- cells of light that comes over several surfaces (render/indirect/)
#define CELL_BITS 7  // of a cell's place along each axis; three more tell which side its normals face
#define CELLS_PER_AXIS (1 << CELL_BITS)
#define CELL_LEVELS 24   // the coarsest: so often the cells' sides have doubled with the distance from the middle
#define CELL_COARSER 2   // levels above: the cells of places that none of the fine ones holds
#define CELL_HASH 2654435761u  // Knuth, The Art of Computer Programming 3, 6.4: 2^32 over the golden ratio
#define CELL_HASH_SHIFT 8
#define CELL_PROBES 16
#define GATHER_MORE 6  // channels of gather.comp besides those of the pass
#define MIRROR_WAYS 2  // of the projector's light over shiny surfaces to a place, at most
#define WAY_TEXELS 2

// How a pixel of the adaptive trace is done, after a look at its neighbourhood.
#define PIXEL_DONE 0    // nothing in it, or the closed form holds
#define PIXEL_SMOOTH 1  // one surface, but the closed form is not good enough
#define PIXEL_FACETS 2  // several facets of one lit mesh
#define PIXEL_MIXED 3   // silhouette, shadow border, end of the projected image
#define PIXEL_MIXED_Y 4 // the same, its edges run rather along x: scan along y
#define PIXEL_OUTLINE 5 // as mixed, but with facets of one mesh and nothing else
#define PIXEL_OUTLINE_Y 6

#define PROBE_MORE 3

// What eight rays along a pixel's border tell.
#define BORDER_SMOOTH 0   // no edge
#define BORDER_CROSSED 1
#define BORDER_FACETS 2   // creases of one lit mesh only
#define BORDER_DENSE 3    // no edge, but too much of the fringe for low orders

#define FACETS_DONE 0
#define FACETS_TOO_MANY 1  // to keep; smaller squares of the pixel hold fewer
#define FACETS_UNKNOWN 2   // something may hide them, or they do not fill the square

#define PIXELS_LISTED 1   // values of SPEC_PIXEL_LIST
#define PIXELS_OUTLINE 2
#define PIXELS_PIECES 3

#define PIXEL_GAPS_SHARP 1
#define PIXEL_GAPS_BLURRED 2

#define SPECULAR_PHONG 1
#define SPECULAR_GGX 2

#define LINKS_SHADOW 1  // links tell where no shadow ray is needed
#define LINKS_WALK 2    // and camera rays find their triangle from a neighbour
#define LINK_SEEN 1     // nothing of the mesh can hide the triangle from the camera
#define LINK_LIT 2      // nor from the projector
#define LINK_CLOSED 4   // of a mesh with an inside

#define MESH_SMOOTH 1
#define MESH_ALBEDO 2

// ---- numbers of the effects: X(member of Params, its four values), set by make_params() (trace/shader_params.cpp).
#define NUMBERS_OF_EFFECTS(X) \
  /* falloff numerator, shadow offset relative to |p|, blur of Gray edges px, first texel of the albedo maps */ \
  X(light, projector.reference_distance_mm * projector.reference_distance_mm, kShadowOffset, projector.blur_px, pass.table_size()) \
  /* lens radius mm, 1/focus distance */ \
  X(projector_optics, lens_radius_mm(projector.optics), per_focus_mm(projector.optics), 0.0, 0.0) \
  /* what the variance of the blur has more at (u, v) of the projector's image: of u, v, u^2, uv; of v^2, the least that there can be */ \
  X(blur_field, projector.blur_field_px2[0], projector.blur_field_px2[1], projector.blur_field_px2[2], projector.blur_field_px2[3]) \
  X(blur_field_rest, projector.blur_field_px2[4], -projector.blur_px * projector.blur_px, 0.0, 0.0) \
  /* ln of the light at (u, v) over its mean: of P1(u), P1(v), P2(u), P1(u) P1(v); P2(v), third order but P3(v); P3(v), fourth order, P4(v) last */ \
  X(light_field_0, projector.light_field_term(0), projector.light_field_term(1), projector.light_field_term(2), projector.light_field_term(3)) \
  X(light_field_1, projector.light_field_term(4), projector.light_field_term(5), projector.light_field_term(6), projector.light_field_term(7)) \
  X(light_field_2, projector.light_field_term(8), projector.light_field_term(9), projector.light_field_term(10), projector.light_field_term(11)) \
  X(light_field_3, projector.light_field_term(12), projector.light_field_term(13), 0.0, 0.0) \
  /* the way to the room's lamp, beyond all objects; what it sends from a surface of diffuse = 1 that faces it. Ambient light beside it */ \
  X(lamp, lamp_way_mm(job).x(), lamp_way_mm(job).y(), lamp_way_mm(job).z(), twin.room.lamp_world.norm()) \
  X(lamp_rest, projector.ambient, 0.0, 0.0, 0.0) \
  /* the middle of the grid of cells in the camera's frame, cells per mm; entries of their table less one */ \
  X(cell_grid, cell_middle_mm(job).x(), cell_middle_mm(job).y(), cell_middle_mm(job).z(), cells_per_mm(job)) \
  X(cell_table, cell_table_mask(job), 0.0, 0.0, 0.0) \
  /* where in a pixel a look goes through it, px from its middle */ \
  X(look, look_px.x(), look_px.y(), 0.0, 0.0) \
  /* samples of the table, lit side of a pixel, phase of the pixel raster at the principal point x, y */ \
  X(projector_gaps, gap_samples(pass), projector.pixel_fill, raster_phase(setup.cx), raster_phase(setup.cy))
#define DECLARE_NUMBERS(member, x, y, z, w) vec4 member;

// All geometry is in the CAMERA frame (camera centre = origin), mm.
struct Params {
  vec4 camera;        // 1/fx, 1/fy, cx, cy
  vec4 lens_grid;     // first x, first y, 1/spacing x, 1/spacing y (px)
  uvec4 lens_grid_n;  // nodes in x, in y, 0, 0
  vec4 projector_r0;  // rows of T_proj_cam: rotation, translation
  vec4 projector_r1;
  vec4 projector_r2;
  vec4 projector_f;     // fx, fy, largest invertible squared radius, 0
  vec4 projector_edge;  // image borders minus the principal point: left, right, top, bottom
  vec4 projector_k0;    // k1 k2 p1 p2
  vec4 projector_k1;    // k3 k4 k5 k6
  vec4 projector_k2;    // s1 s2 s3 s4
  vec4 projector_grid;  // first x, first y, 1/spacing x, 1/spacing y (tangent units)
  uvec4 projector_grid_n;
  vec4 projector_center;      // w: intensity
  vec4 sampling;              // pixel_fill, 1/N, lens radius mm, 1/focus distance
  uvec4 sampling_n;           // N, columns, rows, seed
  vec4 adaptive;              // largest phase error rad, largest irradiance error per pattern, ambient > 0, 0
  uvec4 image;                // width, height, panels of a mixed pixel or parts per side of one of facets, stretches of a line
  uvec4 starts;               // log2 of a tile's side in px, tiles in x, tiles, 0
  NUMBERS_OF_EFFECTS(DECLARE_NUMBERS)
  vec4 pitch[MAX_PITCHES];    // harmonic/pitch, turns at the principal point, axis x, axis y
  vec4 pitch_share[MAX_PITCHES / 4];  // size in the light of each pair that is no fundamental, of its fundamental's
  vec4 direct[MAX_DIRECT];    // scale, offset (table: in samples; pixel: in px; gray: in words), axis x, axis y
  // table: first, count, nodes per unit of defocus; pixel: first, count; gray: bit shift, word mask, value at 0, at 1;
  // image: first, width, height
  vec4 direct_b[MAX_DIRECT];
};

// One dispatch.
struct Push {
  uint first_block;
  uint n_blocks_band;  // stride of the output channels in blocks
  uint first_sample;
  uint end_sample;
  uint n_centre;  // 1: also trace the pixel-centre ray for the object image
  uint sentinel;
  uint resume;    // add to the sums of an earlier dispatch
  uint n_pixels;  // of the list
  uint n_directions;  // in which a place gathers
  uint n_of_way;      // besides, along each way of mirrored light
  uint n_mirrors;     // places of shiny surfaces
};

#ifdef __cplusplus
static_assert(sizeof(vec4) == 16 && sizeof(uvec4) == 16);
static_assert(offsetof(Params, pitch) == 33 * 16);
static_assert(offsetof(Params, direct) == (33 + MAX_PITCHES + MAX_PITCHES / 4) * 16);
static_assert(sizeof(Params) == (33 + MAX_PITCHES + MAX_PITCHES / 4 + 2 * MAX_DIRECT) * 16);
static_assert(sizeof(Push) == 44);
static_assert(CELL_LEVELS < 32 && 3 * CELL_BITS + 3 + 5 < 32);  // a key, and 0 for none
static_assert(2 * sizeof(Params) <= 16384);  // the smallest uniform range Vulkan guarantees
static_assert(BLOCK_WIDTH * BLOCK_HEIGHT == BLOCK_PIXELS);
}  // namespace fringetwin::render::gpu

namespace fringetwin::render {
#define SPEC_OF_KIND(number, KIND, kind, first) SPEC_N_##KIND = number,
#define SPEC_NUMBER(number, name, otherwise, value) SPEC_##name = number,
#define ONE_MORE(...) +1
enum SpecConstant : unsigned {
  ANALYTIC_KINDS(SPEC_OF_KIND) SPECIALISATION_CONSTANTS(SPEC_NUMBER)
  SPEC_COUNT = ANALYTIC_KINDS(ONE_MORE) SPECIALISATION_CONSTANTS(ONE_MORE)
};
#define KIND_NAME(number, KIND, kind, first) KIND_##KIND,
enum PrimitiveKind : unsigned { ANALYTIC_KINDS(KIND_NAME) KIND_MESHES, KIND_COUNT };
#undef SPEC_OF_KIND
#undef SPEC_NUMBER
#undef ONE_MORE
#undef KIND_NAME
}  // namespace fringetwin::render
#endif
#endif
