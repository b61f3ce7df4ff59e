// SPDX-License-Identifier: Apache-2.0
// Everything from a place in a pixel to the projector coordinate that its ray meets.
#include "bindings.glsl"
#include "camera.glsl"
#include "shapes.glsl"
#include "mesh.glsl"
#include "scene.glsl"
#include "refine.glsl"
#include "projector.glsl"
