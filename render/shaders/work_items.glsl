// SPDX-License-Identifier: Apache-2.0
// Which pixel an invocation works on, and what it tells the host at its end.

uint own_slot() {
  return gl_WorkGroupID.x * BLOCK_PIXELS + gl_LocalInvocationID.y * BLOCK_WIDTH + gl_LocalInvocationID.x;
}

uvec2 block_pixel() {
  uint block = texelFetch(block_list, int(push.first_block + gl_WorkGroupID.x)).x;
  return uvec2((block & 0xffffu) * BLOCK_WIDTH, (block >> 16) * BLOCK_HEIGHT) + gl_LocalInvocationID.xy;
}

// Entry `k` of this dispatch's part of the list (x, y, scan along y); past its end the last one again.
uvec3 listed_pixel(uint k) {
  uint code = texelFetch(pixel_list, int(push.first_block + min(k, push.n_pixels - 1u))).x;
  return uvec3(code & 0x7fffu, (code >> 15) & 0x7fffu, code >> 31);
}

// Invocations that fill up the last work group: their loops end at once.
bool beyond_list(uint k) { return PIXEL_LIST != 0 && k >= push.n_pixels; }

// lavapipe cuts all loops of an invocation at 65,535 iterations in total, silently. Once that has
// happened every further loop runs its body once, so this one tells.
void report_status(uvec2 pixel, uint shadow_rays) {
  uint loops = 0;
  for (uint k = 0; k < push.sentinel; ++k) loops += 1 + (k & pixel.x & 0x80000000u);
  if (loops != SENTINEL_LOOPS) atomicAdd(status[0], 1u);
  if (SHADOW != 0) atomicAdd(status[1], shadow_rays);
}
