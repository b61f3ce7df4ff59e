// SPDX-License-Identifier: Apache-2.0
#include "compare/causes/parameters.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "twin/base/errors.hpp"

namespace fringetwin::compare {
namespace {

using Eigen::Vector3d;
using Change = std::function<void(Twin&, double)>;

constexpr double kStepMm = 0.01, kStepRad = 1e-4;
constexpr int kStepsForHarmonics = 6, kMostHarmonics = 7;
constexpr std::size_t kTableLevels =
    1025;  ///< linear between them: the amplitude of harmonic 7 is 0.13 % small

Vector3d unit(int i) { return Vector3d::Unit(i); }

/// "k1" of a lens; a pinhole becomes an OPENCV4 lens.
Lens with_distortion(const Lens& lens, int coefficient, double change, const std::string& device) {
  std::vector<double> intrinsics = lens.intrinsics();
  std::string model = lens.model();
  if (intrinsics.size() < 8) {
    model = "LENSMODEL_OPENCV4";
    intrinsics.resize(8, 0.0);
  }
  intrinsics.at(4 + static_cast<std::size_t>(coefficient)) += change;
  return Lens(model, intrinsics, {lens.width(), lens.height()}, "the lens of " + device + " as changed");
}

/// The projector's response as a table, with a harmonic added.
void add_harmonic(Twin& twin, int order, double amplitude) {
  ProjectorResponse& response = twin.projector->response;
  const double mean = twin.fringes.mean, swing = twin.fringes.amplitude;
  std::vector<double> table(kTableLevels);
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double level = static_cast<double>(i) / static_cast<double>(table.size() - 1);
    const double u = std::clamp((level - mean) / swing, -1.0, 1.0);
    table[i] = response(level) + amplitude * std::cos(order * std::acos(u));
  }
  response.kind = ProjectorResponse::Kind::table;
  response.table = std::move(table);
}

class ParameterList {
 public:
  ParameterList(const Twin& twin, std::string group) : twin_(twin), group_(std::move(group)) {}

  std::vector<Parameter> run() {
    if (group_ == "pose")
      for (std::size_t k = 0; k < twin_.objects.size(); ++k) add_object(k);
    if (group_ == "rig") add_rig();
    if (group_ == "lens") add_lenses();
    if (group_ == "response") add_response();
    if (group_ == "harmonics") add_harmonics();
    if (group_ == "blur") add_blur();
    if (group_ == "vignetting") add_vignetting();
    if (group_ == "albedo") add_albedo();
    if (group_ == "bounce") add_bounce();
    return std::move(list_);
  }

 private:
  Parameter& add(const std::string& name, const std::string& unit, double start, double step, Change change) {
    return list_.emplace_back(Parameter{.group = group_,
                                        .name = name,
                                        .unit = unit,
                                        .start = start,
                                        .step = step,
                                        .change = std::move(change)});
  }

  void add_object(std::size_t k) {
    const Object& object = twin_.objects[k];
    std::visit(
        [&]<class S>(const S& shape) {
          for (const Motion<S>& m : motions(shape))
            add(object.name + "." + m.name, m.unit, m.start, m.unit == "mm" ? kStepMm : kStepRad,
                [k, move_by = m.move_by](Twin& t, double d) {
                  move_by(std::get<S>(t.objects.at(k).shape), d);
                });
        },
        object.shape);
  }

  /// Poses of the projector and of the second camera, each in its own frame.
  void add_rig() {
    if (twin_.projector) add_device("projector", [](Twin& t) -> Pose& { return t.projector->T_proj_world; });
    for (std::size_t c = 1; c < twin_.cameras.size(); ++c)
      add_device(twin_.cameras[c].name, [c](Twin& t) -> Pose& { return t.cameras[c].T_cam_world; });
  }

  template <class PoseOf>
  void add_device(const std::string& name, PoseOf pose_of) {
    for (int i = 0; i < 3; ++i)
      add(fmt::format("{}.turn_rad.{}", name, "xyz"[i]), "rad", 0.0, 0.1 * kStepRad,
          [pose_of, i](Twin& t, double d) {
            Pose& T = pose_of(t);
            T = turned(T, unit(i), d, Vector3d::Zero());
          });
    for (int i = 0; i < 3; ++i)
      add(fmt::format("{}.shift_mm.{}", name, "xyz"[i]), "mm", 0.0, kStepMm,
          [pose_of, i](Twin& t, double d) { pose_of(t).translation_mm[i] += d; });
  }

  void add_lenses() {
    if (twin_.projector)
      add_lens("projector", twin_.projector->lens, [](Twin& t) -> Lens& { return t.projector->lens; });
    for (std::size_t c = 0; c < twin_.cameras.size(); ++c)
      add_lens(twin_.cameras[c].name, twin_.cameras[c].lens,
               [c](Twin& t) -> Lens& { return t.cameras[c].lens; });
  }

  template <class LensOf>
  void add_lens(const std::string& name, const Lens& lens, LensOf lens_of) {
    if (!lens.is_perspective()) return;
    for (int i = 0; i < 2; ++i)
      add(fmt::format("{}.k{}", name, i + 1), "", lens.opencv_distortion()[i], 1e-3,
          [lens_of, i, name](Twin& t, double d) {
            Lens& changed = lens_of(t);
            changed = with_distortion(changed, i, d, name);
          });
  }

  void add_response() {
    if (!twin_.projector || twin_.projector->response.kind == ProjectorResponse::Kind::table) return;
    const ProjectorResponse& r = twin_.projector->response;
    Parameter& p = add("projector.gamma", "", r.kind == ProjectorResponse::Kind::gamma ? r.gamma : 1.0, 0.01,
                       [](Twin& t, double d) {
                         ProjectorResponse& response = t.projector->response;
                         response.gamma =
                             (response.kind == ProjectorResponse::Kind::gamma ? response.gamma : 1.0) + d;
                         response.kind = ProjectorResponse::Kind::gamma;
                       });
    p.smallest = 0.2;
    p.largest = 5.0;
  }

  /// response(v) + sum a_k T_k((v - mean)/amplitude), k = 2 ...: the Chebyshev polynomial T_k makes cos(t) to
  /// cos(kt), so a_k is the amplitude of the k-th harmonic of the projected fringe. With few steps their
  /// orders cannot be told from the fundamental.
  void add_harmonics() {
    const int most = std::min(kMostHarmonics, twin_.fringes.steps - 2);
    if (!twin_.projector || twin_.fringes.steps < kStepsForHarmonics) return;
    for (int k = 2; k <= most; ++k)
      add(fmt::format("projector.harmonic.{}", k), "", 0.0, 1e-3,
          [k](Twin& t, double d) { add_harmonic(t, k, d); });
  }

  /// Contrast falls with the square of the width, so that is what is fitted.
  void add_blur() {
    if (!twin_.projector) return;
    const double sigma_px = twin_.projector->blur_px;
    Parameter& p = add("projector.blur_px", "px", sigma_px * sigma_px, 0.05, [](Twin& t, double d) {
      double& blur_px = t.projector->blur_px;
      blur_px = std::sqrt(std::max(0.0, blur_px * blur_px + d));
    });
    p.is_variance = true;
    p.smallest = 0.0;
  }

  void add_vignetting() {
    for (std::size_t c = 0; c < twin_.cameras.size(); ++c) {
      const Vignetting& v = twin_.cameras[c].vignetting;
      if (v.kind == Vignetting::Kind::cos4) continue;
      for (int i = 0; i < 2; ++i)
        add(fmt::format("{}.vignetting_tilt.{}", twin_.cameras[c].name, "xy"[i]), "", v.tilt[i], 0.01,
            [c, i](Twin& t, double d) {
              Vignetting& changed = t.cameras[c].vignetting;
              changed.kind = Vignetting::Kind::polynomial;
              changed.tilt[i] += d;
            });
      add(fmt::format("{}.vignetting.a1", twin_.cameras[c].name), "", v.a[0], 0.01, [c](Twin& t, double d) {
        t.cameras[c].vignetting.kind = Vignetting::Kind::polynomial;
        t.cameras[c].vignetting.a[0] += d;
      });
    }
  }

  void add_albedo() {
    for (std::size_t k = 0; k < twin_.objects.size(); ++k) {
      Parameter& p = add(twin_.objects[k].name + ".diffuse", "", twin_.objects[k].material.diffuse, 0.01,
                         [k](Twin& t, double d) { t.objects[k].material.diffuse += d; });
      p.smallest = 1e-6;
    }
  }

  /// Two convex bodies, or one mesh, can light each other; one sphere, plane or cylinder cannot.
  void add_bounce() {
    const bool alone =
        twin_.objects.size() == 1 &&
        !std::visit([]<class S>(const S&) { return S::kLightsItself; }, twin_.objects[0].shape);
    if (!twin_.projector || alone || twin_.objects.empty()) return;
    Parameter& p = add("bounces", "", twin_.render.bounces, 1.0,
                       [](Twin& t, double d) { t.render.bounces += static_cast<int>(std::lround(d)); });
    p.is_switch = true;
    p.smallest = 0.0;
    p.largest = 1.0;
  }

  std::vector<Parameter> list_;
  const Twin& twin_;
  std::string group_;
};

}  // namespace

double Parameter::shown(double value) const { return is_variance ? std::sqrt(std::max(0.0, value)) : value; }

double Parameter::shown_sigma(double value, double sigma) const {
  if (!is_variance) return sigma;
  // near zero the root's error is no longer its derivative's
  return value > sigma ? 0.5 * sigma / std::sqrt(value)
                       : std::sqrt(std::max(0.0, value) + sigma) - shown(value);
}

const std::vector<ParameterGroup>& parameter_groups() {
  static const std::vector<ParameterGroup> groups{
      {"pose", "where the objects are", "an object is not where the twin says (pose)"},
      {"rig", "poses of the projector and the second camera", "pose of the projector or the second camera"},
      {"lens", "radial distortion k1, k2 of every lens", "lens distortion"},
      {"response", "gamma of the projector", "the projector's response (gamma)"},
      {"harmonics", "harmonics 2 to 7 of the projected fringe (6 steps or more)",
       "harmonics of the projected fringe"},
      {"blur", "width of the projector's blur", "blur of the projected pattern"},
      {"vignetting", "gain over each camera's image: tilt and r^2",
       "gain that varies over the image (vignetting)"},
      {"albedo", "diffuse reflectivity of each object", "reflectivity of the objects (albedo)"},
      {"bounce", "light that reaches a surface by way of another",
       "a second bounce of the light (interreflection)"},
  };
  return groups;
}

const ParameterGroup& parameter_group(const std::string& name) {
  for (const ParameterGroup& group : parameter_groups())
    if (group.name == name) return group;
  FT_CHECK(false, "a known parameter group");
  return parameter_groups().front();
}

std::vector<Parameter> parameters_of(const Twin& twin, const std::string& group) {
  return ParameterList(twin, group).run();
}

Twin with_values(const Twin& twin, const std::vector<Parameter>& parameters, const Eigen::VectorXd& values) {
  Twin out = twin;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (const double d = values[i] - parameters[i].start; d != 0.0) parameters[i].change(out, d);
  for (Object& object : out.objects) std::visit([](auto& shape) { make_units(shape); }, object.shape);
  return out;
}

Eigen::VectorXd start_values(const std::vector<Parameter>& parameters) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t i = 0; i < parameters.size(); ++i) values[i] = parameters[i].start;
  return values;
}

}  // namespace fringetwin::compare
