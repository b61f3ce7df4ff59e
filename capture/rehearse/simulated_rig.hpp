// SPDX-License-Identifier: Apache-2.0
// A rig made of a twin: its cameras record what the renderer says while its projector shows patterns, on a
// clock of their own. The same recording code runs on it, so an acquisition can be rehearsed without
// hardware.
#pragma once
#include <cstdint>
#include <memory>

#include "capture/device/camera_device.hpp"
#include "capture/device/pattern_display.hpp"
#include "render/renderer.hpp"
#include "twin/twin.hpp"

namespace fringetwin::capture {

struct SimulatedOptions {
  std::uint64_t seed = 0;
  double period_ms = 1000.0 / 60.0;   ///< between frames; longer exposures stretch it
  double latency_ms = 20.0;           ///< from the call of show() until the light changes
  double default_exposure_ms = 10.0;  ///< of a camera whose twin names none
  double camera_offset_ms = 0.9;      ///< each camera's frames begin so much later than the one's before
};

/// Renders every pattern once; each frame is the time average of what was shown while it was exposed, then
/// the sensor's noise. The n-th frame of a pattern has the same noise in every run of one seed. A frame of
/// the whole exposure of one pattern without noise is what `render` writes.
class SimulatedRig {
 public:
  /// The twin ready to render (meshes loaded, measured shapes built). Throws what the renderer throws.
  SimulatedRig(const Twin& twin, const render::Sampling& sampling, render::Renderer& renderer,
               const SimulatedOptions& options = {});
  std::unique_ptr<CameraDevice> camera(std::size_t index) const;
  std::unique_ptr<PatternDisplay> display() const;

  struct World;  ///< shared by the devices; internal

 private:
  std::shared_ptr<World> world_;
};

}  // namespace fringetwin::capture
