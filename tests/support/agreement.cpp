// SPDX-License-Identifier: Apache-2.0
#include "tests/support/agreement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "twin/base/errors.hpp"

namespace fringetwin::testing {
namespace {

constexpr double pi = std::numbers::pi;

// Index in the sequence of the first step of every (direction, pitch).
std::vector<std::size_t> first_steps(const Fringes& fringes) {
  std::vector<std::size_t> out;
  const auto sequence = expand_sequence(fringes);
  for (std::size_t i = 0; i < sequence.size(); ++i)
    if (!sequence[i].is_gray() && sequence[i].step == 0) out.push_back(i);
  return out;
}

bool counts(const ReferenceBlockPixel& p, Pixels pixels) {
  switch (pixels) {
    case Pixels::interior:
      return p.interior;
    case Pixels::hit:
      return p.pixel.mean > 0.0;
    case Pixels::all:
      return true;
  }
  return false;
}

}  // namespace

std::vector<ReferenceBlockPixel> reference_block(const render::Reference& reference, std::size_t camera,
                                                 const PixelBlock& block,
                                                 const render::ReferenceQuadrature& quadrature,
                                                 bool only_interior) {
  const Lens& lens = reference.twin().cameras.at(camera).lens;
  std::vector<ReferenceBlockPixel> out;
  for (int y = block.y0; y < block.y0 + block.height; y += block.stride)
    for (int x = block.x0; x < block.x0 + block.width; x += block.stride)
      if (x >= 0 && y >= 0 && x < lens.width() && y < lens.height()) out.push_back({x, y, false, {}});
  const auto n = static_cast<std::ptrdiff_t>(out.size());
#pragma omp parallel for schedule(dynamic, 16)
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    ReferenceBlockPixel& p = out[static_cast<std::size_t>(i)];
    p.interior = reference.is_whole(camera, p.x, p.y);
    for (int dy = -1; dy <= 1 && p.interior; ++dy)
      for (int dx = -1; dx <= 1 && p.interior; ++dx)
        if (dx != 0 || dy != 0) p.interior = reference.is_whole(camera, p.x + dx, p.y + dy);
    if (p.interior || !only_interior) p.pixel = reference.pixel(camera, p.x, p.y, quadrature);
  }
  if (only_interior) std::erase_if(out, [](const ReferenceBlockPixel& p) { return !p.interior; });
  return out;
}

render::Renderer* shared_renderer() {
  static const std::unique_ptr<render::Renderer> renderer = [] {
    try {
      return std::make_unique<render::Renderer>();
    } catch (const UserError& error) {
      if (error.code() != ExitCode::device) throw;
      return std::unique_ptr<render::Renderer>();
    }
  }();
  return renderer.get();
}

render::Renderer& needed_renderer() {
  if (render::Renderer* renderer = shared_renderer()) return *renderer;
  throw std::runtime_error("no Vulkan device found");
}

bool device_required() { return std::getenv("CI") || std::getenv("FRINGETWIN_REQUIRE_DEVICE"); }

double wrap(double phase_rad) { return std::remainder(phase_rad, 2.0 * pi); }

double stepped_phase(int steps, const std::function<double(int)>& value) {
  double c = 0.0, s = 0.0;
  for (int n = 0; n < steps; ++n) {
    c += value(n) * std::cos(2.0 * pi * n / steps);
    s -= value(n) * std::sin(2.0 * pi * n / steps);
  }
  return std::atan2(s, c);
}

double Agreement::worst_phase_rms_rad() const {
  double worst = 0.0;
  for (const PitchAgreement& p : pitches) worst = std::max(worst, p.phase_rms_rad);
  return worst;
}

std::string Agreement::text() const {
  std::string out = fmt::format("n {}", n);
  for (const PitchAgreement& p : pitches)
    out += fmt::format(", phase rms {:.2e} max {:.2e} rad", p.phase_rms_rad, p.phase_max_rad);
  return out + fmt::format(", gray rms {:.2e} max {:.2e} of full scale", gray_rms, gray_max);
}

Agreement compare(const Twin& twin, std::size_t camera, const std::vector<ImageF>& irradiance,
                  const std::vector<ReferenceBlockPixel>& truth, Pixels pixels) {
  const auto steps = first_steps(twin.fringes);
  const Sensor& sensor = twin.cameras.at(camera).sensor;
  const double full_scale = sensor.max_dn() / sensor.gain_dn;
  Agreement a;
  a.pitches.resize(steps.size());
  for (const auto& p : truth) {
    if (!counts(p, pixels)) continue;
    ++a.n;
    const auto rendered = [&](std::size_t i) { return static_cast<double>(irradiance.at(i)(p.x, p.y)); };
    for (std::size_t i = 0; i < irradiance.size(); ++i) {
      const double d = (rendered(i) - p.pixel.irradiance.at(i)) / full_scale;
      a.gray_rms += d * d;
      a.gray_max = std::max(a.gray_max, std::abs(d));
    }
    for (std::size_t k = 0; k < steps.size(); ++k) {
      const auto at = [&](int n) { return steps[k] + static_cast<std::size_t>(n); };
      const double d =
          wrap(stepped_phase(twin.fringes.steps, [&](int n) { return rendered(at(n)); }) -
               stepped_phase(twin.fringes.steps, [&](int n) { return p.pixel.irradiance[at(n)]; }));
      a.pitches[k].phase_mean_rad += d;
      a.pitches[k].phase_rms_rad += d * d;
      a.pitches[k].phase_max_rad = std::max(a.pitches[k].phase_max_rad, std::abs(d));
    }
  }
  const double n = std::max(1, a.n);
  a.gray_rms = std::sqrt(a.gray_rms / n / static_cast<double>(std::max<std::size_t>(1, irradiance.size())));
  for (PitchAgreement& p : a.pitches) {
    p.phase_mean_rad /= n;
    p.phase_rms_rad = std::sqrt(p.phase_rms_rad / n);
  }
  return a;
}

Agreement agreement(const Twin& twin, std::size_t camera, const render::Sampling& sampling,
                    const PixelBlock& block, Pixels pixels, const render::ReferenceQuadrature& quadrature) {
  const auto rendered = shared_renderer()->render(twin, camera, sampling);
  const render::Reference reference(twin);
  return compare(twin, camera, rendered.irradiance, reference_block(reference, camera, block, quadrature),
                 pixels);
}

PixelBlock block_around(const Twin& twin, std::size_t camera, const Eigen::Vector3d& point_world_mm, int side,
                        int stride) {
  const Camera& c = twin.cameras.at(camera);
  const auto q = c.lens.project(c.T_cam_world * point_world_mm);
  FT_CHECK(q.has_value(), "block around a point outside the camera's view");
  return {static_cast<int>(q->x()) - side / 2, static_cast<int>(q->y()) - side / 2, side, side, stride};
}

PixelBlock whole_image(const Twin& twin, std::size_t camera, int stride) {
  const Lens& lens = twin.cameras.at(camera).lens;
  return {0, 0, lens.width(), lens.height(), stride};
}

}  // namespace fringetwin::testing
