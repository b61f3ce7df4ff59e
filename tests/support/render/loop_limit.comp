#version 460
// SPDX-License-Identifier: Apache-2.0
// How many loop iterations one invocation may execute here (lavapipe 22.3: 65,535, silently).
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
layout(local_size_x = 8) in;
layout(push_constant) uniform PushBlock { Push push; };
layout(std430, binding = 0) buffer StatusBlock { uint status[]; };

void main() {
  uint count = 0;
  for (uint i = 0; i < push.end_sample; ++i) count += 1 + (i & gl_GlobalInvocationID.x & 0x80000000u);
  if (gl_GlobalInvocationID.x == 0) status[0] = count;
}
