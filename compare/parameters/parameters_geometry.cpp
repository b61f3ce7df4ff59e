// SPDX-License-Identifier: Apache-2.0
#include "compare/parameters/parameters_geometry.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace fringetwin::compare {
namespace {

using Eigen::Vector3d;
using Change = std::function<void(Twin&, double)>;

constexpr double kStepMm = 0.01, kStepRad = 1e-4, kStepPrincipalPx = 0.02, kStepFocalPx = 0.05;

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

/// The focal lengths fx and fy change in proportion.
Lens with_focal_length(const Lens& lens, double change_px, const std::string& device) {
  std::vector<double> intrinsics = lens.intrinsics();
  intrinsics[1] += change_px * intrinsics[1] / intrinsics[0];
  intrinsics[0] += change_px;
  return Lens(lens.model(), intrinsics, {lens.width(), lens.height()},
              "the lens of " + device + " as changed");
}

Lens with_principal_point(const Lens& lens, int axis, double change_px, const std::string& device) {
  std::vector<double> intrinsics = lens.intrinsics();
  intrinsics[2 + static_cast<std::size_t>(axis)] += change_px;
  return Lens(lens.model(), intrinsics, {lens.width(), lens.height()},
              "the lens of " + device + " as changed");
}

/// One number that says how large a shape is.
template <class S>
struct Size {
  std::string name, unit;
  double start = 0.0, step = 0.0;
  std::function<void(S&, double)> grow_by;
  std::string instead = {};  ///< as Parameter::instead
};

template <class S>
Size<S> radius_of(const S& shape) {
  return {"radius_mm", "mm", shape.radius_mm, kStepMm, [](S& s, double d) { s.radius_mm += d; }};
}
std::vector<Size<SphereShape>> sizes(const SphereShape& s) { return {radius_of(s)}; }
std::vector<Size<CylinderShape>> sizes(const CylinderShape& s) { return {radius_of(s)}; }
std::vector<Size<PlaneShape>> sizes(const PlaneShape&) { return {}; }
std::vector<Size<MeasuredShape>> sizes(const MeasuredShape&) { return {}; }

/// A mesh grows about the mean of its vertices by a factor, of which the logarithm is the parameter.
std::vector<Size<MeshShape>> sizes(const MeshShape& shape) {
  if (!shape.mesh || shape.mesh->vertices_mm.empty()) return {};
  Vector3d middle = Vector3d::Zero();
  for (const auto& p : shape.mesh->vertices_mm) middle += p.cast<double>();
  middle /= static_cast<double>(shape.mesh->vertices_mm.size());
  double farthest_mm = 0.0;
  for (const auto& p : shape.mesh->vertices_mm)
    farthest_mm = std::max(farthest_mm, (p.cast<double>() - middle).norm());
  if (!(farthest_mm > 0.0)) return {};
  const auto grow_by = [middle](MeshShape& s, double d) {
    auto grown = std::make_shared<Mesh>(*s.mesh);
    for (auto& p : grown->vertices_mm)
      p = (middle + std::exp(d) * (p.cast<double>() - middle)).template cast<float>();
    s.mesh = grown;
  };
  return {{"log_scale", "", 0.0, kStepMm / farthest_mm, grow_by,
           "scale the mesh in its file, about the mean of its vertices by exp(log_scale)"}};
}

/// Lists the parameters of one group.
class GeometryList : private GroupList {
 public:
  GeometryList(const Twin& twin, std::string group) : GroupList(std::move(group)), twin_(twin) {}

  std::vector<Parameter> run() {
    for (std::size_t k = 0; k < twin_.objects.size(); ++k) {
      if (group_ == "pose") add_object(k);
      if (group_ == "size") add_size(k);
      if (group_ == "motion") add_motion(k);
    }
    if (group_ == "rig") add_rig();
    if (group_ == "intrinsics" || group_ == "lens") add_lenses();
    return std::move(list_);
  }

 private:
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

  void add_motion(std::size_t k) {
    const Object& object = twin_.objects[k];
    std::visit(
        [&]<class S>(const S& shape) {
          const std::vector<Motion<S>> ways = motions(shape);
          for (std::size_t i = 0; i < ways.size(); ++i)
            add(fmt::format("{}.{}.motion", object.name, ways[i].name), ways[i].unit,
                i < object.motion.size() ? object.motion[i] : 0.0, ways[i].unit == "mm" ? kStepMm : kStepRad,
                [k, i, n = ways.size()](Twin& t, double d) {
                  std::vector<double>& motion = t.objects.at(k).motion;
                  motion.resize(n, 0.0);
                  motion[i] += d;
                });
        },
        object.shape);
  }

  void add_size(std::size_t k) {
    const Object& object = twin_.objects[k];
    std::visit(
        [&]<class S>(const S& shape) {
          for (const Size<S>& size : sizes(shape)) {
            Parameter& p = add(object.name + "." + size.name, size.unit, size.start, size.step,
                               [k, grow_by = size.grow_by](Twin& t, double d) {
                                 grow_by(std::get<S>(t.objects.at(k).shape), d);
                               });
            if (size.unit == "mm") p.smallest = 1e-3 * size.start;
            p.instead = size.instead;
          }
        },
        object.shape);
  }

  /// Poses of the projector and of the second camera, each in its own frame.
  void add_rig() {
    if (twin_.projector)
      add_device("projector", {}, [](Twin& t) -> Pose& { return t.projector->T_proj_world; });
    for (std::size_t c = 1; c < twin_.cameras.size(); ++c)
      add_device(twin_.cameras[c].name, c, [c](Twin& t) -> Pose& { return t.cameras[c].T_cam_world; });
  }

  template <class PoseOf>
  void add_device(const std::string& name, std::optional<std::size_t> camera, PoseOf pose_of) {
    for (int i = 0; i < 3; ++i)
      add(fmt::format("{}.turn_rad.{}", name, "xyz"[i]), "rad", 0.0, 0.1 * kStepRad,
          [pose_of, i](Twin& t, double d) {
            Pose& T = pose_of(t);
            T = turned(T, unit(i), d, Vector3d::Zero());
          })
          .camera = camera;
    for (int i = 0; i < 3; ++i)
      add(fmt::format("{}.shift_mm.{}", name, "xyz"[i]), "mm", 0.0, kStepMm, [pose_of, i](Twin& t, double d) {
        pose_of(t).translation_mm[i] += d;
      }).camera = camera;
  }

  void add_lenses() {
    if (twin_.projector)
      add_lens("projector", {}, twin_.projector->lens, [](Twin& t) -> Lens& { return t.projector->lens; });
    for (std::size_t c = 0; c < twin_.cameras.size(); ++c)
      add_lens(twin_.cameras[c].name, c, twin_.cameras[c].lens,
               [c](Twin& t) -> Lens& { return t.cameras[c].lens; });
  }

  template <class LensOf>
  void add_lens(const std::string& name, std::optional<std::size_t> camera, const Lens& lens,
                LensOf lens_of) {
    if (!lens.is_perspective()) return;
    const auto add_number = [&](const std::string& number, const std::string& px, double start, double step,
                                auto with_change) {
      add(name + "." + number, px, start, step, [lens_of, with_change, name](Twin& t, double d) {
        Lens& changed = lens_of(t);
        changed = with_change(changed, d, name);
      }).camera = camera;
    };
    if (group_ == "intrinsics")
      add_number("focal_px", "px", lens.intrinsics()[0], kStepFocalPx, with_focal_length);
    for (int i = 0; i < 2; ++i) {
      if (group_ == "intrinsics")
        add_number(
            fmt::format("principal_point_px.{}", "xy"[i]), "px",
            lens.intrinsics()[2 + static_cast<std::size_t>(i)], kStepPrincipalPx,
            [i](const Lens& l, double d, const std::string& n) { return with_principal_point(l, i, d, n); });
      else
        add_number(
            fmt::format("k{}", i + 1), "", lens.opencv_distortion()[i], 1e-3,
            [i](const Lens& l, double d, const std::string& n) { return with_distortion(l, i, d, n); });
    }
  }

  const Twin& twin_;
};

}  // namespace

std::vector<Parameter> geometry_parameters(const Twin& twin, const std::string& group) {
  return group == "motion" ? std::vector<Parameter>{} : GeometryList(twin, group).run();
}

std::vector<Parameter> motion_parameters(const Twin& twin) { return GeometryList(twin, "motion").run(); }

std::vector<PlaceKey> size_keys(const Shape& shape) {
  std::vector<PlaceKey> keys;
  std::visit(
      [&](const auto& s) {
        for (const auto& size : sizes(s))
          if (size.instead.empty()) keys.push_back({size.name, {size.start}});
      },
      shape);
  return keys;
}

}  // namespace fringetwin::compare
