// SPDX-License-Identifier: Apache-2.0
// Measures one capture set, real and simulated alike: images become phases, points and fits.
#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "measure/decode/decode.hpp"
#include "measure/fit/object_fits.hpp"
#include "measure/points/points.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/twin.hpp"

namespace fringetwin::measure {

struct Measurement {
  std::vector<CameraDecode> cameras;  ///< order of twin.cameras
  PointCloud cloud;
  TriangulationSummary triangulation;
  std::vector<ObjectFit> fits;
  std::map<std::string, double> timing_s;  ///< decode, match, triangulate, fit
  std::vector<std::string> warnings;
  std::vector<std::string> gate_warnings;  ///< those of them that fit/gate_warnings.hpp has for the fits
};

/// Refuses, as measure() would, fringes that cannot be unwrapped over the projector's image. Nothing to check
/// without a projector.
void check_fringes(const Twin& twin);

/// True when the rig and its fringes give points: two cameras, or one and a projector, and absolute phases.
bool can_triangulate(const Twin& twin);

/// Returns how measure() decodes the images of a camera: the twin's modulation limit, projector size and
/// sensor noise.
DecodeOptions decode_options(const Twin& twin, const Camera& camera, const CameraImages& images,
                             const std::vector<int>& use_steps = {});

/// Measures. `images`: order of twin.cameras. Decodes only where the rig cannot triangulate (one camera and
/// no projector, or unwrap = "none"). Throws UserError as the stages do, Cancelled after Ctrl-C. smoothing_px
/// (default: the twin's) > 0: coordinates are smoothed (smooth_coordinates) before triangulation; Measurement
/// keeps the raw ones.
Measurement measure(const Twin& twin, const std::vector<CameraImages>& images,
                    const std::vector<int>& use_steps = {}, std::optional<double> smoothing_px = {});

/// True when measure() decodes these images alike with both twins.
bool decodes_alike(const Twin& a, const Twin& b, const std::vector<CameraImages>& images);
/// Does the rest of measure() on what it would have decoded with this twin.
Measurement measure_decoded(const Twin& twin, std::vector<CameraDecode> cameras,
                            std::optional<double> smoothing_px = {});

/// Returns the points that the twin's own images without noise, irradiance or gray values, give at the pixels
/// of this measurement of the twin; none where its fits have no method bias.
PointCloud noise_free_points(const Twin& twin, const std::vector<CameraImages>& noise_free,
                             const Measurement& of_twin, const std::vector<int>& use_steps = {});
/// States the method bias of a measurement's fits (measure/fit/method_bias.hpp) with these points. Nothing
/// happens without fits.
void state_method_bias(const Twin& twin, const PointCloud& noise_free, Measurement& measurement);
/// The same with the points at the pixels of the measurement itself.
inline void state_method_bias(const Twin& twin, const std::vector<CameraImages>& noise_free,
                              Measurement& measurement, const std::vector<int>& use_steps = {}) {
  state_method_bias(twin, noise_free_points(twin, noise_free, measurement, use_steps), measurement);
}

/// Writes points.ply and phase_<camera>.exr (channels: docs/formats/results.md). result.json is the caller's.
void write_measurement(const std::filesystem::path& dir, const Measurement& measurement);

}  // namespace fringetwin::measure
