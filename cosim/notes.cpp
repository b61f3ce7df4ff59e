// SPDX-License-Identifier: Apache-2.0
#include "cosim/notes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace fringetwin::cosim {
namespace {

/// Was the object's nominal size and place taken from the published result?
bool is_published_result(const Object& object, const PublishedFit& fit) {
  const auto same = [&fit](const char* key, const Eigen::Vector3d& nominal) {
    const auto it = fit.vectors.find(key);
    return it != fit.vectors.end() && it->second == nominal;
  };
  const auto* sphere = std::get_if<SphereShape>(&object.shape);
  if (!sphere) return false;
  const auto radius = fit.numbers.find("radius_mm");
  return same("center_mm", sphere->center_mm) && radius != fit.numbers.end() &&
         radius->second == sphere->radius_mm;
}

/// Returns the radius of the windows that a shape is fitted in, or the range of it.
std::string windows_text(const MeasuredShape& shape) {
  return shape.most_smoothing_px > shape.smoothing_px
             ? fmt::format("{:g} to {:g} px", shape.smoothing_px, shape.most_smoothing_px)
             : fmt::format("{:g} px", shape.smoothing_px);
}

}  // namespace

std::string measured_shape_note(const Twin& twin, const std::vector<int>& compared_steps) {
  for (const Object& object : twin.objects) {
    const auto* measured = std::get_if<MeasuredShape>(&object.shape);
    if (!measured) continue;
    if (compared_steps.empty())
      return fmt::format(
          "The object \"{}\" was built from all phase steps of this same capture, so it agrees with its "
          "phase by construction: only the gray levels are evidence here.",
          object.name);
    return fmt::format(
        "The object \"{}\" was built from the {} phase steps of this same capture (smoothed over {}) "
        "and is compared with the other steps ({}). This can show photometric errors (gain, response, noise, "
        "reflectivity), phase noise, harmonics and errors of the rendering chain. It cannot show errors of "
        "the calibration or of the shape that are common to all steps: those moved the object along with the "
        "images. {}",
        object.name, measured->steps, windows_text(*measured), fmt::join(compared_steps, ", "),
        measured->correct_fringes
            ? "Light that differs from image to image and the harmonics of the fringes, as all steps tell "
              "them together, were taken out of the images before the object was built."
            : "A harmonic of the projected fringe one order beside the number of steps used leaves a ripple "
              "of opposite sign in even and odd steps, so it shows here with twice its size (table "
              "\"phase difference, split\").");
  }
  return "";
}

std::string published_results_note(const Twin& twin) {
  if (twin.real.results.empty()) return "";
  std::string note =
      "No images of the physical measurement are at hand, only its published numbers: gray levels and phase "
      "are not compared.";
  for (const PublishedFit& fit : twin.real.results) {
    const Object* object = twin.find_object(fit.object);
    if (object && is_published_result(*object, fit))
      note += fmt::format(
          " The virtual object \"{}\" IS the published result, so its place and size agree by construction: "
          "the differences are the error of rendering and measuring, not the agreement of twin and rig. Its "
          "rms against the published rms is evidence: the twin lacks what the difference is made of.",
          object->name);
  }
  return note;
}

}  // namespace fringetwin::cosim
