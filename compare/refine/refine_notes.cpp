// SPDX-License-Identifier: Apache-2.0
#include "compare/refine/refine_notes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/verdict/explain_code.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kHighCorrelation = 0.98;

}  // namespace

void note_correlations(const GroupFit& fit, const std::vector<std::size_t>& told, Refinement& report) {
  const auto m = static_cast<Eigen::Index>(told.size());
  const std::vector<Parameter>& parameters = fit.parameters();
  report.covariance = Eigen::MatrixXd(m, m);
  for (Eigen::Index i = 0; i < m; ++i)
    for (Eigen::Index j = 0; j < m; ++j) {
      const std::size_t at = told[static_cast<std::size_t>(i)], other = told[static_cast<std::size_t>(j)];
      const GroupFit::Known &a = fit.known()[at], &b = fit.known()[other];
      const double r = fit.covariance()(static_cast<Eigen::Index>(at), static_cast<Eigen::Index>(other)) /
                       a.noise_sigma / b.noise_sigma;
      report.covariance(i, j) = r * a.sigma * b.sigma;
      // what images do not tell of expected ones is taken for none
      const bool is_taken = parameters[at].expected > 0.0 && parameters[other].expected > 0.0;
      if (j < i && std::abs(r) > kHighCorrelation && !is_taken)
        report.notes.push_back(fmt::format("{} and {} are told apart poorly (correlation {:+.3f})",
                                           parameters[other].name, parameters[at].name, r));
    }
}

void note_texture(const std::vector<GridSamples>& samples, Refinement& report, Twin& twin) {
  for (const GridSamples& s : samples) {
    Camera& camera = twin.cameras[s.camera];
    camera.texture_file = "texture_" + camera.name + ".exr";  // beside refined.toml
  }
  const OwnKinds& own = report.own;
  report.texture = report.lines;
  report.notes.push_back(fmt::format(
      "every pixel's {} taken from the capture: {} held at the twin's, and neither {} nor what is "
      "common to all images of a pixel is evidence",
      own.factor && own.offset ? "brightness and offset are"
      : own.factor             ? "brightness is"
                               : "offset is",
      own.factor && own.offset ? "gain and black level are"
      : own.factor             ? "the gain is"
                               : "the black level is",
      own.factor && own.offset ? "they" : "it"));
}

void note_light_of_code(const GridSamples& samples, const Twin& twin, std::vector<std::string>& notes) {
  const auto off = [&samples](std::size_t k) { return std::abs(samples.light_of(k) - 1.0); };
  const auto most = std::ranges::max_element(samples.lit_apart, {}, off);
  if (most == samples.lit_apart.end() || !(off(*most) > kLeastOtherLight)) return;
  notes.push_back(fmt::format(
      "{}: the images of the code have light of their own, image {} most of all: {:+.2f} % (fitted beside "
      "what was asked for, and not kept)",
      twin.cameras[samples.camera].name, samples.images[*most], 100.0 * (samples.light_of(*most) - 1.0)));
}

}  // namespace fringetwin::compare
