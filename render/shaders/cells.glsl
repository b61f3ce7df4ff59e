// SPDX-License-Identifier: Apache-2.0
// Light that has come over a surface already (render/indirect/light_cells.hpp): the irradiance of small cells
// of the surfaces, each a cube of space and one of six sides that its normals face.

// The key of the cell of a place, so many levels above its own; 0 beyond the grid. indirect/cell_grid.cpp has
// the same.
uint cell_key(vec3 p, vec3 n, int coarser) {
  vec3 r = (p - params.cell_grid.xyz) * params.cell_grid.w;
  float far = max(max(abs(r.x), abs(r.y)), abs(r.z)) * (1.0 / float(CELLS_PER_AXIS / 2));
  bool within = far < float(1 << (CELL_LEVELS - CELL_COARSER));
  int level = findMSB(uint(within ? far : 0.0)) + 1 + coarser;
  float per_cell = uintBitsToFloat(uint(127 - level) << 23);  // 2^-level, without rounding
  vec3 at = floor(r * per_cell) + float(CELLS_PER_AXIS / 2);
  vec3 a = abs(n);
  bool x = a.x >= max(a.y, a.z), y = !x && a.y >= a.z;
  float facing = x ? n.x : y ? n.y : n.z;
  uint side = (x ? 0u : y ? 2u : 4u) + (facing > 0.0 ? 0u : 1u);
  uvec3 u = uvec3(clamp(at, 0.0, float(CELLS_PER_AXIS - 1)));
  uint place = u.x | u.y << CELL_BITS | u.z << (2 * CELL_BITS);
  return within ? 1u + (place | side << (3 * CELL_BITS) | uint(level) << (3 * CELL_BITS + 3)) : 0u;
}

// The number of the cell of a place, else of the coarser one around it, -1 where there is none. The table has
// it within CELL_PROBES entries.
int find_cell(vec3 p, vec3 n) {
  uint mask = uint(params.cell_table.x);
  int found = -1;
  for (int coarser = 0; coarser <= CELL_COARSER && found < 0; coarser += CELL_COARSER) {
    uint key = cell_key(p, n, coarser), at = (key * CELL_HASH) >> CELL_HASH_SHIFT;
    for (uint k = 0; k < CELL_PROBES; ++k) {
      int entry = 2 * int((at + k) & mask);
      if (key != 0u && texelFetch(cell_table, entry).x == key) found = int(texelFetch(cell_table, entry + 1).x);
      if (found >= 0) break;
    }
  }
  return found;
}

// Adds what a surface sends on of light that reached it over others. `share`: of it that counts, its
// reflectivity included.
void add_light_of_cell(const Hit hit, float share, inout float mean, inout float cosine[MAX_PITCHES],
                       inout float sine[MAX_PITCHES], inout float direct[MAX_DIRECT]) {
  int cell = hit.primitive >= 0 && share > 0.0 ? find_cell(hit.p, hit.n_geometric) : -1;
  float w = cell >= 0 ? share : 0.0;
  int at = max(cell, 0) * (1 + 2 * N_PITCHES + N_DIRECT);
  mean += w * texelFetch(cell_light, at).x;
#define ADD_CELL_PITCH(i)                                      \
  if (i < N_PITCHES) {                                         \
    cosine[i] += w * texelFetch(cell_light, at + 1 + 2 * i).x; \
    sine[i] += w * texelFetch(cell_light, at + 2 + 2 * i).x;   \
  }
#define ADD_CELL_DIRECT(i) \
  if (i < N_DIRECT) direct[i] += w * texelFetch(cell_light, at + 1 + 2 * N_PITCHES + i).x;
  REPEAT32(ADD_CELL_PITCH)
  REPEAT16(ADD_CELL_DIRECT)
}
