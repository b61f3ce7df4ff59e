// SPDX-License-Identifier: Apache-2.0
#include "tests/support/povray.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <future>
#include <numbers>
#include <thread>

#include "report/process.hpp"
#include "twin/base/errors.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::testing {
namespace {

namespace fs = std::filesystem;

constexpr double kHeadroom = 0.9;  // a colour map wraps at exactly 1

std::string number(double value) { return fmt::format("({:.17g})", value); }
std::string vector(const Eigen::Vector3d& v) {
  return fmt::format("<{:.17g},{:.17g},{:.17g}>", v.x(), v.y(), v.z());
}

/// Cosine series of the pattern through the response, each order lowered by the blur;
/// those below 1e-9 are 0.
std::vector<double> blurred_series(const Twin& twin, double pitch_px) {
  const Projector& p = *twin.projector;
  constexpr int samples = 1 << 14, orders = 64;
  std::vector<double> series;
  for (int k = 0; k <= orders; ++k) {
    const double turn = k * p.blur_px / pitch_px;
    const double left = std::exp(-2.0 * std::numbers::pi * std::numbers::pi * turn * turn);
    if (left < 1e-9) return series;
    double sum = 0.0;
    for (int i = 0; i < samples; ++i) {
      const double theta = 2.0 * std::numbers::pi * i / samples;
      sum += p.response(twin.fringes.mean + twin.fringes.amplitude * std::cos(theta)) * std::cos(k * theta);
    }
    series.push_back((k == 0 ? 1.0 : 2.0) * left * sum / samples);
    if (std::abs(series.back()) < 1e-9) series.back() = 0.0;
  }
  FT_CHECK(false, "the blur is too small for a series of 64 orders");
  return series;
}

/// Projected value 0...1 as a function of the phase, "x".
std::string waveform(const Twin& twin, double pitch_px) {
  const ProjectorResponse& response = twin.projector->response;
  if (twin.projector->blur_px == 0.0) {
    const std::string cosine = number(twin.fringes.mean) + "+" + number(twin.fringes.amplitude) + "*cos(x)";
    if (response.kind == ProjectorResponse::Kind::linear) return cosine;
    FT_CHECK(response.kind == ProjectorResponse::Kind::gamma, "POV-Ray: no table response without blur");
    return "pow(max(" + cosine + ",0)," + number(response.gamma) + ")";
  }
  std::string text = "0";
  const std::vector<double> series = blurred_series(twin, pitch_px);
  for (std::size_t k = 0; k < series.size(); ++k)
    if (series[k] != 0.0) text += fmt::format("+{}*cos({}*x)", number(series[k]), k);
  return text;
}

/// #declare coordinate(x, y, z): the projector's column or row of a point of the world.
std::string coordinate_function(const Projector& p, Axis axis) {
  const auto row = [&](int i) {
    return fmt::format("({}*x+{}*y+{}*z+{})", number(p.T_proj_world.rotation(i, 0)),
                       number(p.T_proj_world.rotation(i, 1)), number(p.T_proj_world.rotation(i, 2)),
                       number(p.T_proj_world.translation_mm[i]));
  };
  FT_CHECK(p.lens.is_perspective(), "POV-Ray: the projector's lens is no perspective one");
  const auto& d = p.lens.opencv_distortion();
  FT_CHECK(d.tail<7>().isZero(), "POV-Ray: the projector's lens has more than k1 k2 p1 p2 k3");
  const auto& f = p.lens.intrinsics();
  const bool x_axis = axis == Axis::x;
  // of x, y on the plane z = 1 and z = x^2 + y^2
  const std::string distorted =
      fmt::format("{0}*({1}*(1+z*({2}+z*({3}+z*{4})))+2*{5}*x*y+{6}*(z+2*{1}*{1}))+{7}",
                  number(f[x_axis ? 0 : 1]), x_axis ? "x" : "y", number(d[0]), number(d[1]), number(d[4]),
                  number(d[x_axis ? 2 : 3]), number(d[x_axis ? 3 : 2]), number(f[x_axis ? 2 : 3]));
  return "#declare plane_x = function(x,y,z) { " + row(0) + "/" + row(2) + " };\n" +
         "#declare plane_y = function(x,y,z) { " + row(1) + "/" + row(2) + " };\n" +
         "#declare distorted = function(x,y,z) { " + distorted + " };\n" +
         "#declare on_plane = function(x,y) { distorted(x,y,x*x+y*y) };\n" +
         "#declare coordinate = function(x,y,z) { on_plane(plane_x(x,y,z),plane_y(x,y,z)) };\n";
}

std::string camera_text(const Camera& camera, double dx_px, double dy_px) {
  FT_CHECK(camera.lens.model() == "LENSMODEL_PINHOLE", "POV-Ray: cameras are pinhole");
  const auto& f = camera.lens.intrinsics();
  const double width = camera.lens.width(), height = camera.lens.height();
  const Pose T_world_cam = camera.T_cam_world.inverse();
  const Eigen::Vector3d middle((0.5 * (width - 1.0) + dx_px - f[2]) / f[0],
                               (0.5 * (height - 1.0) + dy_px - f[3]) / f[1], 1.0);
  return fmt::format("camera {{ perspective location {} direction {} right {} up {} }}\n",
                     vector(T_world_cam.translation_mm), vector(T_world_cam.rotation * middle),
                     vector(T_world_cam.rotation.col(0) * width / f[0]),
                     vector(T_world_cam.rotation.col(1) * -height / f[1]));
}

std::string object_text(const Object& object) {
  FT_CHECK(object.material.specular == 0.0, "POV-Ray: diffuse materials only");
  FT_CHECK(object.material.diffuse <= 1.0, "POV-Ray: a reflectivity above 1 would be clipped");
  const std::string texture =
      fmt::format("texture {{ fringe finish {{ ambient 0 diffuse {} specular 0 phong 0 }} }} }}\n",
                  object.material.diffuse);
  if (const auto* sphere = std::get_if<SphereShape>(&object.shape))
    return fmt::format("sphere {{ {}, {:.17g} {}", vector(sphere->center_mm), sphere->radius_mm, texture);
  const auto* plane = std::get_if<PlaneShape>(&object.shape);
  FT_CHECK(plane != nullptr && !plane->size_mm, "POV-Ray: spheres and infinite planes only");
  return fmt::format("plane {{ {}, {:.17g} {}", vector(plane->normal), plane->normal.dot(plane->point_mm),
                     texture);
}

/// Outside the projector's image the twin has no light, POV-Ray's functions go on.
void check_covered(const Twin& twin, std::size_t camera) {
  const Camera& c = twin.cameras[camera];
  const Projector& p = *twin.projector;
  for (const Object& object : twin.objects) {
    const auto* plane = std::get_if<PlaneShape>(&object.shape);
    if (plane == nullptr) continue;
    for (const double x : {-0.5, c.lens.width() - 0.5})
      for (const double y : {-0.5, c.lens.height() - 0.5}) {
        const Eigen::Vector3d ray = c.T_cam_world.rotation.transpose() * *c.lens.unproject({x, y});
        const Eigen::Vector3d from = c.center_world_mm();
        const double t = plane->normal.dot(plane->point_mm - from) / plane->normal.dot(ray);
        const auto q = p.lens.project(p.T_proj_world * (from + t * ray));
        FT_CHECK(q && q->x() > 0.0 && q->y() > 0.0 && q->x() < p.lens.width() - 1.0 &&
                     q->y() < p.lens.height() - 1.0,
                 "POV-Ray: the projector's image must cover what the camera sees");
      }
  }
}

/// Gray values 0...1; nullopt where the program cannot be started.
std::optional<ImageF> run_povray(const std::string& scene, int width, int height, int supersampling,
                                 int threads, const fs::path& stem) {
  const fs::path scene_file = stem.string() + ".pov", image_file = stem.string() + ".ppm";
  write_text_file(scene_file, scene);
  std::vector<std::string> argv{
      "povray",
      "+I" + scene_file.string(),
      "+O" + image_file.string(),
      fmt::format("+W{}", width),
      fmt::format("+H{}", height),
      "+FP16",  // 16 bit, gray with the next; OpenEXR would be half floats of 11 bit
      "Grayscale_Output=on",
      "File_Gamma=1.0",
      "-D",
      "-GA",
      fmt::format("+WT{}", threads)};
  if (supersampling > 1)
    argv.insert(argv.end(), {"+A0.0", "+AM1", "-J", fmt::format("+R{}", supersampling)});
  else
    argv.push_back("-A");
  const auto result = report::run_process(argv, "", std::chrono::hours(1));  // a large image takes long
  if (!result || result->status == 127) return std::nullopt;
  if (result->status != 0)
    throw UserError(ExitCode::internal, "povray", "failed: " + result->err.substr(0, 500));
  ImageF gray = read_gray(image_file).image;
  fs::remove(scene_file);
  fs::remove(image_file);
  for (float& v : gray.data) v /= 65535.0F;
  return gray;
}

void add_cells(const ImageF& fine, int cells, double weight, ImageD& sum) {
  for (int y = 0; y < fine.height; ++y)
    for (int x = 0; x < fine.width; ++x)
      sum(x / cells, y / cells) += weight * static_cast<double>(fine(x, y));
}

/// One image of the sequence, 0...1.
std::optional<ImageF> one_image(const Twin& twin, std::size_t camera, const PatternSpec& pattern,
                                const PovraySampling& sampling, const fs::path& stem) {
  const int width = twin.cameras[camera].lens.width(), height = twin.cameras[camera].lens.height();
  if (sampling.own_supersampling)
    return run_povray(povray_scene(twin, camera, pattern, 0.0, 0.0), width, height,
                      *sampling.own_supersampling, sampling.threads, stem);
  const int cells = sampling.cells;
  const double node = 0.5 / std::sqrt(3.0) / cells;  // of the two Gauss points, from the cell's centre
  ImageD sum(width, height, 0.0);
  for (const double dx : {-node, node})
    for (const double dy : {-node, node}) {
      const auto fine = run_povray(povray_scene(twin, camera, pattern, dx, dy), width * cells, height * cells,
                                   1, sampling.threads, stem);
      if (!fine) return std::nullopt;
      add_cells(*fine, cells, 1.0 / (4 * cells * cells), sum);
    }
  ImageF image(width, height);
  std::transform(sum.data.begin(), sum.data.end(), image.data.begin(),
                 [](double v) { return static_cast<float>(v); });
  return image;
}

}  // namespace

std::string povray_scene(const Twin& twin, std::size_t camera, const PatternSpec& pattern, double dx_px,
                         double dy_px) {
  FT_CHECK(pattern.kind == PatternSpec::Kind::phase_step, "POV-Ray: phase steps only");
  const Projector& p = *twin.projector;
  FT_CHECK(p.ambient == 0.0 && !p.inverse_square && !p.optics && !p.pixel_structure,
           "POV-Ray: a projector without ambient light, falloff, defocus and pixels");
  const DirectionFringes& d = twin.fringes.directions[static_cast<std::size_t>(pattern.direction)];
  const auto pitch = static_cast<std::size_t>(pattern.pitch);
  std::string scene = "#version 3.7;\nglobal_settings { assumed_gamma 1.0 }\n";
  scene += camera_text(twin.cameras.at(camera), dx_px, dy_px);
  scene += fmt::format("light_source {{ {} color rgb 1 }}\n", vector(p.center_world_mm()));
  scene += coordinate_function(p, d.axis);
  scene += fmt::format("#declare waveform = function(x) {{ {} }};\n", waveform(twin, d.pitches_px[pitch]));
  scene += fmt::format(
      "#declare fringe = texture {{ pigment {{ function {{ {}*waveform(2*pi*(coordinate(x,y,z)-{})/{}+{}) }} "
      "color_map {{ [0 rgb 0] [1 rgb {:.17g}] }} }} }}\n",
      kHeadroom, number(d.phase_origin_px[pitch]), number(d.pitches_px[pitch]),
      number(2.0 * std::numbers::pi * pattern.step / twin.fringes.steps), 1.0 / kHeadroom);
  for (const Object& object : twin.objects) scene += object_text(object);
  return scene;
}

std::optional<std::vector<ImageF>> povray_irradiance(const Twin& twin, std::size_t camera,
                                                     const PovraySampling& sampling,
                                                     const fs::path& scratch) {
  check_covered(twin, camera);
  const auto patterns = expand_sequence(twin.fringes);
  std::vector<std::optional<ImageF>> images(patterns.size());
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < patterns.size(); i = next++)
      images[i] =
          one_image(twin, camera, patterns[i], sampling, scratch / fmt::format("povray-{}-{}", camera, i));
  };
  const int processes = sampling.processes > 0
                            ? sampling.processes
                            : std::max(2, 2 * static_cast<int>(std::thread::hardware_concurrency()));
  std::vector<std::future<void>> workers;
  for (int i = 0; i < processes; ++i) workers.push_back(std::async(std::launch::async, work));
  for (auto& worker : workers) worker.get();
  std::vector<ImageF> out;
  const auto scale = static_cast<float>(twin.projector->intensity / std::numbers::pi);
  for (auto& image : images) {
    if (!image) return std::nullopt;
    for (float& v : image->data) v *= scale;
    out.push_back(std::move(*image));
  }
  return out;
}

}  // namespace fringetwin::testing
