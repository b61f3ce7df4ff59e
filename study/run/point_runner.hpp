// SPDX-License-Identifier: Apache-2.0
// Runs points of a study: a twin with settings goes in, and the recorded numbers of its virtual measurement
// come out (light, gray values, measurement).
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "render/renderer.hpp"
#include "study/noise/noise_theory.hpp"
#include "study/plan/recorded_numbers.hpp"
#include "study/plan/study_point.hpp"
#include "study/run/trace_share.hpp"
#include "study/uncertain/uncertain_inputs.hpp"

namespace fringetwin::study {

/// What the points of a study have in common.
struct PointTask {
  std::filesystem::path twin;
  std::vector<Record> records;
  /// The settings change the rig that records; the twin as it is measures (VirtualRig).
  bool virtual_rig = false;
  bool calibration = false;  ///< with virtual_rig: it is drawn from the covariance that the twin names
  std::string study{};       ///< StudyIdentity::digest(), for engines that keep results of their own
};

/// Keeps the last point's trace and images for a next one that shares them.
class PointRunner {
 public:
  PointRunner(PointTask task, render::Renderer& renderer);

  /// Never throws for the point's own faults: these are outcomes. Throws Cancelled, and UnknownKey when the
  /// first point lacks a recorded result.
  PointOutcome run(const PlannedPoint& planned);

  /// Returns the images before the sensor, of the last point that came so far.
  const std::vector<render::RenderedCamera>& rendered() const { return rendered_; }

 private:
  /// Returns the numbers; fills in whether light was traced, and what is said of the fits.
  std::map<std::string, double> numbers(const PlannedPoint& planned, PointOutcome& out);
  void load(const StudyPoint& point);
  void trace(const PlannedPoint& planned);
  static bool forms_images_of_a_trace(const Twin& twin);

  PointTask task_;
  render::Renderer& renderer_;
  std::optional<VirtualRig> rig_;  ///< with task_.virtual_rig
  std::optional<Twin> twin_;
  Settings settings_;              ///< of twin_
  std::optional<ShareKeys> keys_;  ///< of traces_ and rendered_
  TraceDemand demand_;             ///< that traces_ meet: another plan of points may ask for more or less
  std::vector<render::Transport> traces_;
  std::vector<render::RenderedCamera> rendered_;
  std::map<std::string, NoiseTheory> theory_;  ///< of twin_, by object
  bool any_measured_ = false;
};

}  // namespace fringetwin::study
