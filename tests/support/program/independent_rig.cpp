// SPDX-License-Identifier: Apache-2.0
#include "tests/support/program/independent_rig.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <span>

#include "render/base/disk_cache.hpp"
#include "tests/support/paper_rig.hpp"
#include "tests/support/povray.hpp"
#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/rig_indirect.hpp"
#include "twin/captures/capture_set.hpp"

namespace fringetwin::testing {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 240, kHeight = 220;  // the ball is 111 px wide

/// 12 bit; the brightest value is about 3300 DN.
Sensor true_sensor(double gain_dn) {
  Sensor sensor;
  sensor.bit_depth = 12;
  sensor.gain_dn = gain_dn;
  sensor.black_level_dn = 40.0;
  sensor.electrons_per_dn = 10.0;
  sensor.read_noise_dn = 2.0;
  return sensor;
}

Camera shortened(Camera camera, double gain_dn) {
  std::vector<double> f = camera.lens.intrinsics();
  camera.lens =
      Lens("LENSMODEL_PINHOLE", {f[0] / 3.0, f[1] / 3.0, f[2] / 3.0, f[3] / 3.0}, {480, 360}, camera.name);
  camera.sensor = true_sensor(gain_dn);
  return camera;
}

Material matt(double diffuse) {
  Material material;
  material.diffuse = diffuse;
  return material;
}

ImageF recorded(const ImageF& irradiance, const ImageF* added, const Sensor& sensor, double gain_tilt,
                std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  ImageF dn(irradiance.width, irradiance.height);
  for (int y = 0; y < dn.height; ++y)
    for (int x = 0; x < dn.width; ++x) {
      const double e =
          static_cast<double>(irradiance(x, y)) + (added ? static_cast<double>((*added)(x, y)) : 0.0);
      const double light_dn = sensor.gain_dn * (1.0 + gain_tilt * (x / (dn.width - 1.0) - 0.5)) * e;
      const double sigma =
          std::sqrt(light_dn / *sensor.electrons_per_dn + *sensor.read_noise_dn * *sensor.read_noise_dn);
      dn(x, y) = static_cast<float>(std::clamp(
          std::round(light_dn + sensor.black_level_dn + sigma * normal(random)), 0.0, sensor.max_dn()));
    }
  return dn;
}

/// One camera's images: what an earlier run made from the same code and scenes, else `make()`.
template <class Make>
std::vector<ImageF> kept(const std::string& what, const Twin& twin, std::size_t camera, const Make& make) {
  std::string made_from = what + FRINGETWIN_CODE_DIGEST;
  const auto patterns = expand_sequence(twin.fringes);
  for (const PatternSpec& pattern : patterns) made_from += povray_scene(twin, camera, pattern, 0.0, 0.0);
  const std::string name = what + "-" + render::content_key({std::as_bytes(std::span(made_from))});
  const Lens& lens = twin.cameras[camera].lens;
  std::vector<ImageF> images(patterns.size(), ImageF(lens.width(), lens.height()));
  const auto bytes = render::read_cached(render::cache_folder(), name);
  const std::size_t size = images[0].size() * sizeof(float);
  if (bytes && bytes->size() == images.size() * size) {
    for (std::size_t i = 0; i < images.size(); ++i)
      std::memcpy(images[i].data.data(), bytes->data() + i * size, size);
    return images;
  }
  images = make();
  std::vector<float> all;
  for (const ImageF& image : images) all.insert(all.end(), image.data.begin(), image.data.end());
  if (!all.empty()) render::write_cached(render::cache_folder(), name, {std::as_bytes(std::span(all))});
  return images;
}

RigImages render_rig(RigLight light) {
  const Twin twin = independent_rig(light);
  RigImages images;
  for (std::size_t camera = 0; camera < twin.cameras.size(); ++camera) {
    images.push_back(kept("povray", twin, camera, [&] {
      return povray_irradiance(twin, camera, {.cells = 2}, scratch_folder("povray"))
          .value_or(std::vector<ImageF>{});
    }));
    if (images.back().empty()) return {};
  }
  return images;
}

std::string list(const std::vector<double>& values) {
  return fmt::format("[{:.17g}]", fmt::join(values, ", "));
}
std::string list(const Eigen::Vector3d& v) { return list(std::vector<double>{v.x(), v.y(), v.z()}); }

std::string device_text(const Lens& lens, const Pose& T_device_world) {
  const RotTrans rt = rt_from_pose(T_device_world);
  return fmt::format("lensmodel = \"{}\"\nimagersize = [{}, {}]\nintrinsics = {}\nrt_cam_world = {}\n",
                     lens.model(), lens.width(), lens.height(), list(lens.intrinsics()),
                     list(std::vector<double>(rt.data(), rt.data() + 6)));
}

std::string camera_text(const Camera& camera, double gain_factor) {
  const Sensor& s = camera.sensor;
  return fmt::format(
      "[[camera]]\nname = \"{}\"\n{}[camera.sensor]\nbit_depth = {}\ngain_dn = {}\n"
      "black_level_dn = {}\nelectrons_per_dn = {}\nread_noise_dn = {}\n",
      camera.name, device_text(camera.lens, camera.T_cam_world), s.bit_depth, gain_factor * s.gain_dn,
      s.black_level_dn, *s.electrons_per_dn, *s.read_noise_dn);
}

}  // namespace

Twin independent_rig(RigLight light) {
  const SphereShape ball = physical_sphere();
  Twin twin = paper_rig();
  twin.name = "independent rig";
  twin.cameras = {shortened(twin.cameras[0], 330.0), shortened(twin.cameras[1], 320.0)};
  twin = crop_around(twin, ball.center_mm, kWidth, kHeight);
  PlaneShape wall = frontal_plane(300.0);
  wall.normal = Eigen::Vector3d(0.05, -0.08, -1.0).normalized();
  twin = with_object(std::move(twin), "ball", ball, matt(TwinOptions{}.ball_diffuse));
  twin = with_object(std::move(twin), "wall", wall, matt(TwinOptions{}.wall_diffuse));
  if (light == RigLight::bent) {
    twin.projector->response = {.kind = ProjectorResponse::Kind::gamma, .gamma = 1.2, .table = {}};
    twin.projector->blur_px = 1.0;
  }
  return twin;
}

const RigImages& rig_images(RigLight light) {
  if (light == RigLight::bent) {
    static const RigImages bent = render_rig(RigLight::bent);
    return bent;
  }
  static const RigImages linear = render_rig(RigLight::linear);
  return linear;
}

const RigImages& rig_indirect_images() {
  static const RigImages indirect = [] {
    const Twin twin = independent_rig();
    RigImages images;
    for (std::size_t camera = 0; camera < twin.cameras.size(); ++camera)
      images.push_back(kept("indirect", twin, camera, [&] { return indirect_irradiance(twin, camera); }));
    return images;
  }();
  return indirect;
}

std::vector<CameraImages> captured_images(const CaptureOptions& options) {
  const Twin twin = independent_rig(options.light);
  const RigImages& images = rig_images(options.light);
  const RigImages* added = options.second_bounce ? &rig_indirect_images() : nullptr;
  std::mt19937_64 random(options.seed);
  std::vector<CameraImages> out(twin.cameras.size());
  for (std::size_t c = 0; c < twin.cameras.size(); ++c) {
    const Camera& camera = twin.cameras[c];
    out[c].camera = camera.name;
    out[c].bit_depth = camera.sensor.bit_depth;
    for (std::size_t i = 0; i < images.at(c).size(); ++i)
      out[c].images.push_back(recorded(images[c][i], added ? &added->at(c).at(i) : nullptr, camera.sensor,
                                       options.gain_tilt, random));
  }
  return out;
}

void write_captures(const fs::path& folder, const CaptureOptions& options) {
  const std::vector<CameraImages> captured = captured_images(options);
  std::vector<const CameraImages*> written;
  for (const CameraImages& images : captured) {
    write_camera_images(folder, images);
    written.push_back(&images);
  }
  write_capture_toml(folder, written, {{"device", "POV-Ray"}}, "png");
}

std::string twin_toml(const fs::path& captures, const TwinOptions& options) {
  const Twin twin = independent_rig();
  std::string text = "schema = \"fringetwin-twin/1\"\nname = \"independent rig\"\n";
  for (const Camera& camera : twin.cameras) text += camera_text(camera, options.gain_factor);

  const Projector& p = *twin.projector;
  std::vector<double> intrinsics = p.lens.intrinsics();
  if (!options.projector_k1) intrinsics[4] = 0.0;
  const Lens lens(p.lens.model(), intrinsics, {p.lens.width(), p.lens.height()}, "projector");
  text += fmt::format("[projector]\n{}intensity = {}\nblur_px = {}\n", device_text(lens, p.T_proj_world),
                      p.intensity, options.blur_px);
  if (options.gamma != 1.0) text += fmt::format("response = {{ gamma = {} }}\n", options.gamma);
  const DirectionFringes& d = twin.fringes.directions[0];
  text += fmt::format("[fringes]\ndirections = [\"x\"]\npitches_px = {}\nsteps = {}\n", list(d.pitches_px),
                      twin.fringes.steps);

  const auto& ball = std::get<SphereShape>(twin.objects[0].shape);
  const auto& wall = std::get<PlaneShape>(twin.objects[1].shape);
  text += fmt::format(
      "[[object]]\nname = \"ball\"\nshape = \"sphere\"\ncenter_mm = {}\nradius_mm = {}\n"
      "[object.material]\ndiffuse = {}\n",
      list(Eigen::Vector3d(ball.center_mm + options.sphere_shift_mm)), ball.radius_mm, options.ball_diffuse);
  text += fmt::format(
      "[[object]]\nname = \"wall\"\nshape = \"plane\"\npoint_mm = {}\nnormal = {}\n"
      "[object.material]\ndiffuse = {}\n",
      list(wall.point_mm), list(wall.normal), options.wall_diffuse);
  text += "[measure]\ntriangulate = \"stereo\"\nmin_modulation_dn = 20\n";
  for (const Object& object : twin.objects)
    text += fmt::format("[[measure.fit]]\nobject = \"{}\"\n", object.name);
  text += "[render]\n";
  if (options.bounces > 0)
    text += fmt::format("bounces = {}\nbounce_samples = 512\n",
                        options.bounces >= kAllBounces ? "\"all\"" : std::to_string(options.bounces));
  if (options.samples > 0) text += fmt::format("sampler = \"gauss\"\nsamples = {}\n", options.samples);
  text += fmt::format("[real]\ncaptures = \"{}\"\n", captures.string());
  return text;
}

}  // namespace fringetwin::testing
