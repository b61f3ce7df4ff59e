// SPDX-License-Identifier: Apache-2.0
// Renders a twin with Vulkan: traces one camera for the transport of light, which serves all patterns, and
// forms the irradiance images that the camera receives (docs/PHYSICS.md, "Trace once, shade all").
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "render/base/device_info.hpp"
#include "render/base/rendered_camera.hpp"
#include "render/base/renderer_tuning.hpp"
#include "render/base/sampling.hpp"
#include "render/base/transport.hpp"
#include "twin/base/not_copyable.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

class TraceDevice;
struct SceneStores;

class Renderer : NotCopyable {
 public:
  /// `device`: "" = default (lavapipe unless FRINGETWIN_DEVICE says otherwise) or a part of a name.
  /// Throws UserError(device) when there is none, listing what there is.
  explicit Renderer(const std::string& device = "");
  ~Renderer();

  const DeviceInfo& device() const;

  /// Traces one camera of a twin whose meshes are loaded and whose MeasuredShapes are replaced. Throws
  /// UserError(usage) when the camera is inside an object or the twin has no projector.
  Transport trace(const Twin& twin, std::size_t camera_index, const Sampling& sampling,
                  std::uint64_t seed = 0);
  /// Traces a camera and forms its images; with `references` also white and black images where the sequence
  /// needs none. Where an object moves (Object::motion) every image has a trace of its own, or two where the
  /// camera has an ExposureTiming; all else is that of the twin as it is, the middle of the sequence, the
  /// error the largest of all traces.
  RenderedCamera render(const Twin& twin, std::size_t camera_index, const Sampling& sampling,
                        std::uint64_t seed = 0, bool references = false);
  /// Does the same without references, the images kept in little memory (keep_camera()).
  KeptCamera render_kept(const Twin& twin, std::size_t camera_index, const Sampling& sampling,
                         std::uint64_t seed = 0);

  /// Forces the traces from now on onto certain ways, for tests and benchmarks.
  void set_tuning(const RendererTuning& tuning) { tuning_ = tuning; }
  /// Returns the number of warnings and errors of the Vulkan validation layers so far
  /// (FRINGETWIN_VALIDATION=1).
  int validation_messages() const;

 private:
  /// Renders the image of a colour sensor's channel as pixels of its whole sensor, over which the point
  /// spread reaches.
  RenderedCamera render_of_whole_sensor(const Twin& twin, std::size_t camera_index, const Sampling& sampling,
                                        std::uint64_t seed, bool references);
  RenderedCamera render_moving(const Twin& twin, std::size_t camera_index, const Sampling& sampling,
                               std::uint64_t seed, bool references);
  /// Gives a transport the series of the harmonics' field and the places that they are taken at.
  void add_harmonics_field(const Twin& twin, std::size_t camera_index, Transport& transport);
  void choose_precision(const Twin& twin, const Sampling& sampling);

  std::unique_ptr<TraceDevice> device_;
  std::unique_ptr<SceneStores> stores_;
  RendererTuning tuning_;
};

}  // namespace fringetwin::render
