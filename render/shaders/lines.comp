#version 460
// SPDX-License-Identifier: Apache-2.0
// Pixels that an edge crosses. One invocation = one scan line through such a pixel, or a stretch of one where the
// driver's limit of loop iterations asks for it: it finds where along
// the line the surface changes (bisection between probes), and integrates each piece by Gauss-Legendre,
// so that its result is as good as if there were no edge. The host adds the lines up.
//
// Towards an edge the nodes crowd quadratically: at the silhouette of a curved surface the phase changes
// with the square root of the distance, which becomes a polynomial.
#extension GL_GOOGLE_include_directive : require
#include "ray.glsl"
#include "patterns.glsl"
#include "shade.glsl"
#include "work_items.glsl"
#include "identity.glsl"
#include "look.glsl"

layout(local_size_x = BLOCK_WIDTH, local_size_y = BLOCK_HEIGHT) in;

const int PROBES = 6;  // both ends, and four between, moved from line to line to catch narrow things
const int MOST_BORDERS = 8;
const float INNER_LINE = 0.4472135955;  // sqrt(1/5)
const int BISECTIONS = 7;              // a quarter pixel to 2e-3 px
const float UNRESOLVED = 0.25 / 128.0 * 0.2886751346;  // rms of what is left: an interval over sqrt(12)
// Four nodes are good to 4e-6 over so many rad: evenly spaced, crowding towards one edge, towards two.
const float MOST_SWING[3] = float[3](3.0, 0.75, 0.4);
const int MOST_PARTS = 48;           // of a line
const float SHORTEST_STEP = 0.05;    // of a line, between two probes that tell the slope
const vec4 NODES = vec4(0.0694318442, 0.3300094782, 0.6699905218, 0.9305681558);
const vec4 WEIGHTS = vec4(0.1739274226, 0.3260725774, 0.3260725774, 0.1739274226);

// By how much a wrong border between the two changes an image of the finest fringe at full modulation.
float unresolved_jump(Seen a, Seen b, float finest) {
  float both = min(a.w, b.w);
  float turn = both > 0.0 ? min(2.0, finest * length(vec2(a.u - b.u))) : 0.0;
  return abs(a.w - b.w) + both * turn + ((a.id != 0.0) != (b.id != 0.0) ? params.adaptive.z : 0.0);
}

// How far the projector coordinate moves (px) across the scan lines in a pixel, by the rays through the neighbours.
float px_across(ivec2 pixel, ivec2 across) {
  vec4 c = probe_at(pixel);
  float most = 0.0;
  for (int side = -1; side <= 1; side += 2) {
    ivec2 q = pixel + side * across;
    vec4 v = in_image(q) ? probe_at(q) : c;
    most = max(most, c.w > 0.0 && v.w > 0.0 && primitive_of(c.w) == primitive_of(v.w) ? length(v.xy - c.xy) : 0.0);
  }
  return most;
}

float probe_position(int i, float jitter) {
  return i == 0 ? -0.5 : i == PROBES - 1 ? 0.5 : (float(i - 1) + jitter) * 0.25 - 0.5;
}

void main() {
  load_constants();
  uint slot = own_slot(), stride = push.n_blocks_band * BLOCK_PIXELS;
  uint panels = params.image.z, stretches = params.image.w;
  uint entry = slot / (LINES_PER_PANEL * panels * stretches), line = slot / stretches % (LINES_PER_PANEL * panels);
  float stretch = 1.0 / float(stretches);
  uvec3 pixel = listed_pixel(entry);
  start_walks(uvec2(pixel.xy));
  PixelRays rays = pixel_rays(vec2(pixel.xy));
  float fill = params.sampling.x;
  // Lobatto's four nodes in each panel: the outer lines lie on its borders and see what only just enters.
  uint node = line % LINES_PER_PANEL;
  float in_panel = node == 0 ? -1.0 : node == 1 ? -INNER_LINE : node == 2 ? INNER_LINE : 1.0;
  float across = (float(line / LINES_PER_PANEL) + 0.5 + 0.5 * in_panel) / float(panels) - 0.5;
  vec2 start = fill * (pixel.z != 0 ? vec2(across, 0.0) : vec2(0.0, across));
  vec2 along = fill * (pixel.z != 0 ? vec2(0.0, 1.0) : vec2(1.0, 0.0));
  start += ((float(slot % stretches) + 0.5) * stretch - 0.5) * along;
  along *= stretch;

  float jitter = fract((float(line) + 0.5) * 0.618034);
  // Probes from one end to the other; between two that differ, bisection.
  float borders[MOST_BORDERS + 2];
  borders[0] = -0.5;
  bool beyond = beyond_list(entry);
  int n_pieces = beyond ? 0 : 1;
  uint shadow_rays = 0, rays_cast = 0;
  float unresolved = 0.0, finest = finest_fringe(), finest_to_sample = finest_swing();
  float low = 0.0, high = 0.0, slope = 0.0, position_before = -0.5;
  Seen at_low = Seen(0.0, 0.0, real2(0.0), NEVER_BELOW), at_high = at_low, last = at_low;
  int next = beyond ? PROBES : 0, halvings = 0;
  while (next < PROBES || halvings > 0) {
    bool halving = halvings > 0;
    float position = halving ? 0.5 * (low + high) : probe_position(next, jitter);
    Seen seen = look(rays, start + position * along, shadow_rays);
    rays_cast += 1;
    bool start_halving = false;
    if (halving) {
      if (same_surface(at_low, seen)) {
        low = position;
        at_low = seen;
      } else {
        high = position;
        at_high = seen;
      }
      halvings -= 1;
      if (halvings == 0) {
        borders[n_pieces] = 0.5 * (low + high);
        float jump = unresolved_jump(at_low, at_high, finest);
        unresolved += jump * jump;
        n_pieces += 1;
        // A third surface between the two probes: on from here.
        start_halving = !same_surface(at_high, last) && n_pieces <= MOST_BORDERS;
        low = high;
        at_low = at_high;
      }
    } else {
      bool same = next > 0 && same_surface(last, seen);
      start_halving = next > 0 && !same && n_pieces <= MOST_BORDERS;
      if (same && last.w > 0.0 && seen.w > 0.0 && position - position_before > SHORTEST_STEP)
        slope = max(slope, length(vec2(seen.u - last.u)) / (position - position_before));
      position_before = position;
      low = probe_position(max(next - 1, 0), jitter);
      at_low = last;
      last = seen;
      next += 1;
    }
    if (start_halving) {
      high = probe_position(next - 1, jitter);
      at_high = last;
      halvings = BISECTIONS;
    }
  }
  borders[n_pieces] = 0.5;

  float mean = 0.0, hits = 0.0;
  float cosine[MAX_PITCHES], sine[MAX_PITCHES], direct[MAX_DIRECT];
  load_sums(false, slot, stride, mean, hits, cosine, sine, direct);
  int parts_used = 0;
  bool too_few = false;
  for (int piece = 0; piece < n_pieces; ++piece) {
    // An edge may lie just beyond the end of a stretch.
    bool edge_left = piece > 0 || slot % stretches > 0u,
         edge_right = piece < n_pieces - 1 || slot % stretches < stretches - 1u;
    float a = borders[piece], b = borders[piece + 1];
    float limit = MOST_SWING[(edge_left ? 1 : 0) + (edge_right ? 1 : 0)];
    int wanted = int(ceil(min(finest_to_sample * slope * (b - a) / limit, 1e6)));
    int parts = clamp(wanted, 1, max(1, MOST_PARTS - parts_used));
    parts_used += parts;
    too_few = too_few || wanted > parts;
    for (int k = 0; k < 4 * parts; ++k) {
      float t = (float(k >> 2) + NODES[k & 3]) / float(parts), r = 1.0 - t;
      float s = edge_left ? (edge_right ? t * t * (3.0 - 2.0 * t) : t * t) : (edge_right ? 1.0 - r * r : t);
      float ds = edge_left ? (edge_right ? 6.0 * t * r : 2.0 * t) : (edge_right ? 2.0 * r : 1.0);
      Seen seen = look(rays, start + (a + (b - a) * s) * along, shadow_rays);
      rays_cast += 1;
      float weight = WEIGHTS[k & 3] / float(parts) * ds * (b - a) * stretch;
      float w = seen.w * weight;
      mean += w;
      hits += seen.id != 0.0 ? weight : 0.0;
      below = seen.below;
      add_patterns(w, w != 0.0 ? seen.u : real2(0.0), cosine, sine, direct);
    }
  }
  float error = UNRESOLVED * stretch * sqrt(unresolved);
  // Lines that the fringe passes by too fast may agree by chance.
  if (finest_to_sample * fill * px_across(ivec2(pixel.xy), pixel.z != 0 ? ivec2(1, 0) : ivec2(0, 1)) > 4.0 * float(panels)) too_few = true;
  error = too_few ? max(error, mean) : error;
  store_sums(slot, stride, mean, hits, cosine, sine, direct);
  sums[slot + (2 + 2 * N_PITCHES + N_DIRECT) * stride] = error;
  atomicAdd(status[2], rays_cast);
  report_status(pixel.xy, shadow_rays);
}
