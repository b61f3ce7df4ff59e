// SPDX-License-Identifier: Apache-2.0
// The Vulkan renderer: one trace of a camera, then all its patterns (docs/PHYSICS.md, "Trace once, shade
// all").
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/pattern/response_series.hpp"
#include "twin/image/image.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

struct DeviceInfo {
  std::string name;         ///< e.g. "llvmpipe (LLVM 15.0.6, 256 bits)"
  std::string driver;       ///< e.g. "llvmpipe Mesa 22.3.6"
  std::string api_version;  ///< e.g. "1.3.230"
  bool is_cpu = false;
  bool has_double = false;  ///< traces in double precision (shaderFloat64)
};
/// Empty when there is no Vulkan loader, driver or device.
std::vector<DeviceInfo> list_devices();

/// How the pixels are sampled, after the defaults.
///  gauss: samples = n x n Gauss-Legendre; multi_jittered, sobol: any number;
///  adaptive: one ray and a closed form where one surface fills the pixel's neighbourhood, facets clipped
///  exactly, more rays only where the estimated error is too large and along edges (docs/PHYSICS.md);
///  `samples` is then meaningless.
struct Sampling {
  Sampler sampler = Sampler::gauss;
  int samples = 4;
  bool precise = false;           ///< rays and phases in double precision, where the device can
  double phase_error_rad = 1e-4;  ///< adaptive: target at the finest pitch
  double gray_error = 1e-4;       ///< adaptive: target, fraction of the sensor's full scale
};
/// Total phase error (rms, rad) of the single-precision kernels on the worst scene, a tilted plane over the
/// whole frame; for targets below it double precision is used. Rounding shifts the projector coordinate by
/// some 6e-8 of the projector's focal length: 3.5e-5 rad measured at 1700 px and a pitch of 13 px, stated as
/// 5e-5, in proportion to focal length over pitch elsewhere.
double single_precision_error_rad(const Twin& twin);

/// What the user fixed, or else what meets the targets at the least cost, for a twin's own options or others.
/// Throws UserError(usage) when gauss samples are no square of 1...16, or samples < 1 / > 65536.
Sampling choose_sampling(const Twin& twin, const RenderOptions& options);
inline Sampling choose_sampling(const Twin& twin) { return choose_sampling(twin, twin.render); }
const char* sampler_name(Sampler sampler);  ///< as in twin.toml: "gauss", "multi-jittered" ...
/// The fixed rule that stands in where the adaptive trace does not apply (depth of field, projector optics
/// and pixels, albedo maps, bounces).
Sampling without_adaptation(const Sampling& sampling);
/// The same with as many points as the fringes ask for that one pixel of this camera sees: two points a side
/// leave w^4/4320 too much contrast, w the phase across the pixel.
Sampling without_adaptation(const Sampling& sampling, const Twin& twin, const Camera& camera);
void check_sampling(const Sampling& sampling, double pixel_fill);

/// The renderer's own estimate of its error, meant as an upper bound (tested on scenes of its own).
struct ErrorEstimate {
  double phase_rad = 0.0;    ///< rms at the finest pitch over lit pixels without an edge, rounding included
  double gray = 0.0;         ///< rms over all pixels that see an object, fraction of full scale
  double mixed_share = 0.0;  ///< of those pixels, the share that an edge crosses
  double facets_share = 0.0;
  double smooth_share = 0.0;  ///< the share that needed more than the closed form
};

/// One step of the adaptive trace, for benchmarks.
struct StageCost {
  std::string name;
  std::size_t pixels = 0;
  std::uint64_t rays = 0;
  double cpu_ms = 0.0;  ///< of all threads of the process
};

/// Per-pixel transport of one camera (all images W x H, irradiance per unit pattern value).
/// E = weight-sum form of docs/PHYSICS.md; a pattern with harmonics a_k (response, blur included) gives
/// E = ambient_hit + sum_k a_k (cosine_k cos(k delta) - sine_k sin(k delta)).
struct Transport {
  ImageF mean;     ///< mean of w over the pixel (pattern value 1 everywhere)
  ImageF ambient;  ///< ambient irradiance x hit fraction
  /// [direction][pitch]: mean of w cos(theta), w sin(theta), theta = 2 pi (x - origin)/pitch; the
  /// fundamental with the blur attenuation already in it. Empty where the steps are evaluated directly.
  std::vector<std::vector<ImageF>> cosine, sine;
  /// [direction][pitch][k - 2]: the same of harmonic k >= 2, where the response is not linear.
  struct Pair {
    ImageF cosine, sine;
  };
  std::vector<std::vector<std::vector<Pair>>> harmonics;
  /// [direction][pitch]: a_k of the form above before blur; empty where the steps are evaluated directly.
  SeriesTable series;
  /// Images evaluated directly in the trace (mean of w * value), by sequence index; empty elsewhere.
  std::vector<ImageF> direct;
  Image<std::int32_t> object;  ///< index of the object at the pixel centre's ray, -1 none
  Sampling sampling;           ///< what was done: a fixed rule where adaptive does not apply
  double trace_ms = 0.0;
  std::uint64_t rays = 0;                 ///< primary + shadow
  std::optional<ErrorEstimate> estimate;  ///< adaptive only
  std::vector<StageCost> stages;          ///< adaptive only
};

struct RenderedCamera {
  std::string camera;
  std::vector<ImageF> irradiance;      ///< E per image, sequence order
  std::optional<ImageF> white, black;  ///< when needs_white_black(), or asked for
  Image<std::int32_t> object;
  Sampling sampling;
  double trace_ms = 0.0, total_ms = 0.0;
  std::uint64_t rays = 0;
  std::optional<ErrorEstimate> estimate;
};

class Renderer {
 public:
  /// `device`: "" = default (lavapipe unless FRINGETWIN_DEVICE says otherwise) or a part of a name.
  /// Throws UserError(device) when there is none, listing what there is.
  explicit Renderer(const std::string& device = "");
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  const DeviceInfo& device() const;

  /// Meshes must be loaded and MeasuredShapes replaced. Throws UserError(usage) when the camera is
  /// inside an object.
  Transport trace(const Twin& twin, std::size_t camera_index, const Sampling& sampling,
                  std::uint64_t seed = 0);
  /// `references`: white and black images, also where the sequence needs none.
  RenderedCamera render(const Twin& twin, std::size_t camera_index, const Sampling& sampling,
                        std::uint64_t seed = 0, bool references = false);

  /// Warnings and errors of the Vulkan validation layers so far (FRINGETWIN_VALIDATION=1).
  int validation_messages() const;
  /// For tests: most samples per pixel in one dispatch (0 = default). lavapipe 22.3 cuts the loops of
  /// an invocation at 65,535 iterations; the renderer notices and repeats with fewer samples.
  void set_samples_per_dispatch(std::uint32_t samples);
  /// For tests and benchmarks: how phase steps behind a response that is not linear are made.
  void set_pattern_method(PatternMethod method);
  /// For tests and benchmarks: find every ray's triangle through the BVH, and trace every shadow ray.
  void set_search_always(bool always);
  /// For tests: scan lines in so many invocations each from the start, as where the driver cuts loops short.
  void set_line_stretches(std::uint32_t stretches);
  /// Iterations of a loop of `requested` iterations that one shader invocation really executes.
  std::uint32_t count_loop_iterations(std::uint32_t requested);
  /// Dispatches repeated because of that limit so far.
  int repeated_dispatches() const;

  struct Impl;  ///< internal to render/

 private:
  std::unique_ptr<Impl> impl_;
};

/// Irradiance images from a transport: sequence order.
std::vector<ImageF> form_images(const Twin& twin, const Transport& transport);

/// The images of a traced camera, as Renderer::render() makes them: patterns, then the lens's effects.
RenderedCamera form_camera(const Twin& twin, std::size_t camera_index, const Transport& transport,
                           bool references = false);

/// True when the trace of a camera does not depend on the fringes' mean, amplitude and number of steps: all
/// images are phase steps behind a linear response.
bool holds_any_steps(const Twin& twin);
/// Gives a transport the mean and amplitude of this twin. Needs holds_any_steps(), and > 0 steps, of both
/// twins.
void set_pattern(const Twin& twin, Transport* transport);

}  // namespace fringetwin::render
