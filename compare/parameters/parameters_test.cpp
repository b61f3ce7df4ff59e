// SPDX-License-Identifier: Apache-2.0
// Which numbers of a twin every parameter moves, by how much, and that nothing else moves.
// | check                                | tolerance | origin                                             |
// |--------------------------------------|-----------|----------------------------------------------------|
// | numbers moved directly               | 1e-12     | one rounding of numbers up to 300                  |
// | unit vectors, rotations, sums of two | 1e-12     | a few roundings                                    |
#include "compare/parameters/parameters.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <memory>
#include <random>
#include <set>

#include "twin/base/errors.hpp"

namespace fringetwin::compare::parameters_test {
namespace {

using Eigen::Vector3d;
using ::testing::UnorderedElementsAre;

constexpr double kRounding = 1e-12;

std::shared_ptr<const Mesh> small_mesh() {
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices_mm = {{1, 2, 3}, {9, 2, 4}, {3, 8, 5}, {2, 3, 12}};
  mesh->triangles = {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};
  return mesh;
}

/// One of everything.
Twin rich_twin() {
  Twin twin;
  const Lens pinhole("LENSMODEL_PINHOLE", {900, 905, 319.5, 239.5}, {640, 480}, "test");
  const Lens opencv("LENSMODEL_OPENCV4", {1700, 1701, 600, 400, 0.13, -0.33, 1e-4, -2e-4}, {1280, 720},
                    "test");
  const Pose turned{rotation_from_vector({0.02, 0.7, -0.01}), {-180, -1, 60}};
  twin.cameras.push_back({"left", pinhole, Pose{}, Sensor{}, std::nullopt});
  twin.cameras.push_back({"right", pinhole, turned, Sensor{}, std::nullopt});
  twin.cameras[1].vignetting = {Vignetting::Kind::polynomial, {-0.1, 0.02, 0.0}, {0.01, -0.02}};
  twin.cameras[1].sensor.response = knee_response(120.0, 0.8);
  Projector projector{.lens = opencv, .T_proj_world = turned, .response = {}};
  projector.blur_px = 1.5;
  projector.response.kind = ProjectorResponse::Kind::gamma;
  projector.response.gamma = 2.2;
  twin.projector = projector;
  PlaneShape plane{
      .point_mm = {1, 2, 300}, .normal = Vector3d(0.05, -0.08, -1.0).normalized(), .size_mm = {}};
  plane.u_axis = plane.normal.unitOrthogonal();
  CylinderShape cylinder{
      .point_mm = {4, 2, 275}, .axis = Vector3d(0.1, 1, 0.15).normalized(), .radius_mm = 12, .length_mm = {}};
  MeshShape mesh;
  mesh.T_world_object = Pose{rotation_from_vector({0.3, -0.2, 0.5}), {10, 20, 250}};
  mesh.mesh = small_mesh();
  twin.objects = {{"ball", SphereShape{{6, -5, 270}, 19}, {}},
                  {"wall", plane, {}},
                  {"tube", cylinder, {}},
                  {"part", mesh, {}}};
  twin.objects[0].material.specular = 0.25;
  twin.objects[1].material.specular = 0.25;
  twin.objects[1].material.specular_model = Material::Specular::ggx;
  twin.fringes.steps = 6;
  twin.fringes.directions = {{Axis::x, {13, 14, 15}, {0, 0, 0}, {}}};
  return twin;
}

using Numbers = std::map<std::string, double>;

void put(Numbers& out, const std::string& name, const Vector3d& v) {
  for (int i = 0; i < 3; ++i) out[name + "." + "xyz"[i]] = v[i];
}

void put(Numbers& out, const std::string& name, const Pose& T) {
  for (int i = 0; i < 9; ++i) out[fmt::format("{}.R{}", name, i)] = T.rotation(i / 3, i % 3);
  put(out, name + ".t", T.translation_mm);
}

void put(Numbers& out, const std::string& name, const Lens& lens) {
  for (std::size_t i = 0; i < lens.intrinsics().size(); ++i)
    out[fmt::format("{}.intrinsics{}", name, i)] = lens.intrinsics()[i];
}

void put(Numbers& out, const std::string& name, const Shape& shape) {
  if (const auto* sphere = std::get_if<SphereShape>(&shape)) {
    put(out, name + ".center", sphere->center_mm);
    out[name + ".radius"] = sphere->radius_mm;
  } else if (const auto* plane = std::get_if<PlaneShape>(&shape)) {
    put(out, name + ".point", plane->point_mm);
    put(out, name + ".normal", plane->normal);
    put(out, name + ".u_axis", plane->u_axis);
  } else if (const auto* cylinder = std::get_if<CylinderShape>(&shape)) {
    put(out, name + ".point", cylinder->point_mm);
    put(out, name + ".axis", cylinder->axis);
    out[name + ".radius"] = cylinder->radius_mm;
  } else {
    const auto& mesh = std::get<MeshShape>(shape);
    put(out, name + ".pose", mesh.T_world_object);
    for (std::size_t i = 0; i < mesh.mesh->vertices_mm.size(); ++i)
      put(out, fmt::format("{}.vertex{}", name, i), Vector3d(mesh.mesh->vertices_mm[i].cast<double>()));
  }
}

/// Every number of a twin that a parameter could move.
Numbers numbers_of(const Twin& twin) {
  Numbers out;
  for (const Camera& c : twin.cameras) {
    put(out, c.name + ".lens", c.lens);
    put(out, c.name + ".pose", c.T_cam_world);
    out[c.name + ".gain"] = c.sensor.gain_dn;
    out[c.name + ".black"] = c.sensor.black_level_dn;
    out[c.name + ".psf"] = c.psf_px;
    for (std::size_t i = 0; i < expand_sequence(twin.fringes).size(); ++i)
      out[fmt::format("{}.image_{}.exposure", c.name, i)] = factor_of(c.exposure_factors, i);
    const ExposureTiming timing = c.timing.value_or(ExposureTiming{});
    for (std::size_t i = 0; i < expand_sequence(twin.fringes).size(); ++i)
      out[fmt::format("{}.image_{}.late", c.name, i)] = timing.late_of(i);
    out[c.name + ".read_out"] = timing.read_out;
    for (std::size_t i = 0; i < 3; ++i) out[fmt::format("{}.a{}", c.name, i + 1)] = c.vignetting.a[i];
    for (std::size_t i = 0; i < 2; ++i) out[c.name + ".tilt." + "xy"[i]] = c.vignetting.tilt[i];
    const CameraResponse& response = c.sensor.response;
    out[c.name + ".knee_dn"] = response.straight() ? 0.0 : response.corners[0].in_dn;
    out[c.name + ".slope"] = response.last_slope;
  }
  const Projector& p = *twin.projector;
  put(out, "projector.lens", p.lens);
  put(out, "projector.pose", p.T_proj_world);
  out["projector.intensity"] = p.intensity;
  out["projector.blur"] = p.blur_px;
  for (std::size_t i = 0; i < p.blur_field_px2.size(); ++i)
    out[fmt::format("projector.blur_field{}", i)] = p.blur_field_px2[i];
  out["projector.gamma"] = p.response.gamma;
  out["projector.ambient"] = p.ambient;
  for (std::size_t i = 0; i < kLightFieldTerms.size(); ++i)
    out[fmt::format("projector.light_field{}", i)] = p.light_field_term(i);
  put(out, "room.lamp", twin.room.lamp_world);
  const auto put_harmonics = [&out](const std::string& of, const Harmonics& list, std::size_t lowest) {
    for (std::size_t i = 0; i < list.size(); ++i) {
      out[fmt::format("{}.harmonic{}", of, i + lowest)] = list[i].cosine;
      out[fmt::format("{}.quadrature{}", of, i + lowest)] = list[i].sine;
    }
  };
  put_harmonics("projector", twin.fringes.directions[0].harmonics_of(0), 2);
  const std::vector<Harmonics>& field = twin.fringes.directions[0].harmonics_field;
  for (std::size_t t = 0; t < field.size(); ++t)
    put_harmonics(fmt::format("projector.field{}", t), field[t], 2);
  const DirectionFringes& fringes = twin.fringes.directions[0];
  for (std::size_t i = 0; i < fringes.pitches_px.size(); ++i)
    out[fmt::format("projector.contrast{}", i)] = fringes.contrast_of(i);
  for (std::size_t i = 0; i < expand_sequence(twin.fringes).size(); ++i) {
    out[fmt::format("image_{}.light", i)] = factor_of(p.light_factors, i);
    out[fmt::format("image_{}.shift", i)] = p.image_shift_px(i);
    put_harmonics(fmt::format("image_{}", i), twin.fringes.harmonics_of_image(i), 1);
  }
  for (const Object& object : twin.objects) {
    put(out, object.name, object.shape);
    out[object.name + ".diffuse"] = object.material.diffuse;
    out[object.name + ".specular"] = object.material.specular;
    out[object.name + ".shininess"] = object.material.shininess;
    out[object.name + ".roughness"] = object.material.roughness;
    out[object.name + ".mean_free_path"] = object.material.mean_free_path_mm;
  }
  out["bounces"] = twin.render.bounces > 0 ? 1.0 : 0.0;
  out["bounces.glossy"] = twin.render.glossy_bounces ? 1.0 : 0.0;
  return out;
}

/// Names and amounts of the numbers that differ.
Numbers moved(const Twin& before, const Twin& after) {
  Numbers a = numbers_of(before), b = numbers_of(after), out;
  for (const auto& [name, value] : b)
    if (std::abs(value - (a.contains(name) ? a[name] : 0.0)) > kRounding)
      out[name] = value - (a.contains(name) ? a[name] : 0.0);
  return out;
}

/// Those that change a twin.
std::vector<Parameter> all_parameters(const Twin& twin) {
  std::vector<Parameter> all;
  for (const ParameterGroup& group : parameter_groups())
    for (Parameter& p : parameters_of(twin, group.name))
      if (p.change) all.push_back(std::move(p));
  return all;
}

Parameter named(const Twin& twin, const std::string& name) {
  for (Parameter& p : all_parameters(twin))
    if (p.name == name) return p;
  ADD_FAILURE() << "no parameter " << name;
  return {};
}

Twin with_change(const Twin& twin, const Parameter& p, double change) {
  return with_values(twin, {p}, Eigen::VectorXd::Constant(1, p.start + change));
}

std::set<std::string> names_of(const Twin& twin, const std::string& group) {
  std::set<std::string> names;
  for (const Parameter& p : parameters_of(twin, group)) names.insert(p.name);
  return names;
}

TEST(Parameters, StartValuesGiveTheSameTwin) {
  const Twin twin = rich_twin();
  const std::vector<Parameter> all = all_parameters(twin);
  EXPECT_THAT(moved(twin, with_values(twin, all, start_values(all))), ::testing::IsEmpty());
}

TEST(Parameters, EveryNumberIsMovedByTheChangeItself) {
  const Twin twin = rich_twin();
  const std::map<std::string, std::string> moves{
      {"ball.center_mm.x", "ball.center.x"},
      {"ball.center_mm.y", "ball.center.y"},
      {"ball.center_mm.z", "ball.center.z"},
      {"part.shift_mm.x", "part.pose.t.x"},
      {"part.shift_mm.z", "part.pose.t.z"},
      {"ball.radius_mm", "ball.radius"},
      {"tube.radius_mm", "tube.radius"},
      {"projector.principal_point_px.x", "projector.lens.intrinsics2"},
      {"right.principal_point_px.y", "right.lens.intrinsics3"},
      {"ball.specular", "ball.specular"},
      {"ball.shininess", "ball.shininess"},
      {"wall.roughness", "wall.roughness"},
      {"projector.shift_mm.y", "projector.pose.t.y"},
      {"right.shift_mm.z", "right.pose.t.z"},
      {"projector.k1", "projector.lens.intrinsics4"},
      {"projector.k2", "projector.lens.intrinsics5"},
      {"projector.gamma", "projector.gamma"},
      {"projector.light_field.1_0", "projector.light_field0"},
      {"projector.light_field.2_1", "projector.light_field6"},
      {"projector.light_field.0_4", "projector.light_field13"},
      {"projector.harmonic.2", "projector.harmonic2"},
      {"projector.harmonic.4", "projector.harmonic4"},
      {"projector.harmonic.3.quadrature", "projector.quadrature3"},
      {"projector.harmonics_field.1_0.2", "projector.field0.harmonic2"},
      {"projector.harmonics_field.0_2.4.quadrature", "projector.field4.quadrature4"},
      {"left.vignetting_tilt.x", "left.tilt.x"},
      {"right.vignetting_tilt.y", "right.tilt.y"},
      {"left.vignetting.a1", "left.a1"},
      {"left.image_0.late", "left.image_0.late"},
      {"right.image_17.late", "right.image_17.late"},
      {"right.timing.read_out", "right.read_out"},
      {"right.response.slope", "right.slope"},
      {"right.response.knee_dn", "right.knee_dn"},
      {"ball.mean_free_path_mm", "ball.mean_free_path"},
      {"ball.diffuse", "ball.diffuse"},
      {"part.diffuse", "part.diffuse"},
      {"bounces", "bounces"},
  };
  for (const auto& [parameter, number] : moves) {
    SCOPED_TRACE(parameter);
    const Parameter p = named(twin, parameter);
    const double change = p.is_switch ? 1.0 : 0.0125;
    const Numbers m = moved(twin, with_change(twin, p, change));
    ASSERT_EQ(m.size(), 1u) << m.size();
    EXPECT_EQ(m.begin()->first, number);
    EXPECT_NEAR(m.begin()->second, change, kRounding);
  }
}

TEST(Parameters, AParameterMovesItsOwnThingOnly) {
  const Twin twin = rich_twin();
  for (const Parameter& p : all_parameters(twin)) {
    SCOPED_TRACE(p.name);
    if (p.group == "bounce_albedo") continue;  // of all surfaces and lights: the next test
    const std::string thing = p.name.substr(0, p.name.find('.'));
    const Numbers m = moved(twin, with_change(twin, p, p.is_switch ? 1.0 : 0.01));
    EXPECT_FALSE(m.empty());
    Numbers own = m;
    own.erase("image_0.light");  // gives way to that of another image: the mean is the gain's
    for (const auto& [name, change] : own) EXPECT_EQ(name.substr(0, name.find('.')), thing) << name;
  }
}

// Surfaces that send light to others by their lobes send it by their reflectivity, too.
TEST(Parameters, GlossComesWithBounces) {
  Twin twin = rich_twin();
  EXPECT_EQ(with_change(twin, named(twin, "bounces.glossy"), 1.0).render.bounces, kAllBounces);
  twin.render.bounces = 2;
  const Twin glossy = with_change(twin, named(twin, "bounces.glossy"), 1.0);
  EXPECT_EQ(glossy.render.bounces, 2);
  EXPECT_TRUE(glossy.render.glossy_bounces);
  const Twin off = with_change(glossy, named(glossy, "bounces.glossy"), -1.0);
  EXPECT_EQ(off.render.bounces, 2);
  EXPECT_FALSE(off.render.glossy_bounces);
}

// Of six steps 5 and 7 cannot be told from the fundamental; what pitches have apart they keep.
TEST(Parameters, HarmonicsOfAllPitchesMoveTogether) {
  Twin twin = rich_twin();
  EXPECT_THAT(names_of(twin, "harmonics"),
              UnorderedElementsAre("projector.harmonic.2", "projector.harmonic.2.quadrature",
                                   "projector.harmonic.3", "projector.harmonic.3.quadrature",
                                   "projector.harmonic.4", "projector.harmonic.4.quadrature"));
  twin.fringes.directions[0].harmonics = {{{0.25, 0.5}}, {}, {{0.0, 0.0}, {0.125, 0.0}}};
  const Parameter p = named(twin, "projector.harmonic.2.quadrature");
  EXPECT_EQ(p.start, 0.5);
  const DirectionFringes moved_fringes = with_change(twin, p, 0.25).fringes.directions[0];
  EXPECT_EQ(moved_fringes.harmonics,
            (std::vector<Harmonics>{{{0.25, 0.75}}, {{0.0, 0.25}}, {{0.0, 0.25}, {0.125, 0.0}}}));
  twin.fringes.steps = 5;
  EXPECT_THAT(names_of(twin, "harmonics"), ::testing::IsEmpty());
}

TEST(Parameters, TermsOfTheBlursField) {
  Twin twin = rich_twin();
  twin.projector->blur_px = 1.0;
  twin.projector->optics.reset();
  twin.projector->pixel_structure = false;
  twin.fringes.unwrap = Unwrap::heterodyne;
  EXPECT_EQ(names_of(twin, "blur_field").size(), 5u);
  const Parameter p = named(twin, "projector.blur_field_px2.uv");
  EXPECT_EQ(with_change(twin, p, 0.25).projector->blur_field_px2, (std::array{0.0, 0.0, 0.0, 0.25, 0.0}));
  twin.projector->blur_px = 0.0;  // a variance that rises on one side would be negative on the other
  EXPECT_THAT(names_of(twin, "blur_field"), ::testing::IsEmpty());
}

// What all pitches share, in the units of the widest one.
TEST(Parameters, ContrastOfAllFringesScalesThatOfEachPitch) {
  Twin twin = rich_twin();
  twin.fringes.directions[0].pitches_px = {16, 64, 4.5};
  twin.fringes.directions[0].contrast = {0.9, 0.8, 1.0};
  EXPECT_THAT(names_of(twin, "fringe_contrast"), ::testing::ElementsAre("projector.fringe_contrast"));
  const Parameter p = named(twin, "projector.fringe_contrast");
  EXPECT_EQ(p.start, 0.8);
  EXPECT_EQ(p.largest, 2.0 * 0.8);  // then the contrast of the finest is 2, the most that a twin may have
  const std::vector<double> halved = with_change(twin, p, -0.4).fringes.directions[0].contrast;
  ASSERT_EQ(halved.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(halved[k], 0.5 * twin.fringes.directions[0].contrast[k], kRounding);
}

// What the widest pitch has is that of all.
TEST(Parameters, ContrastOfEachPitchButTheWidest) {
  Twin twin = rich_twin();
  twin.fringes.directions[0].pitches_px = {16, 64, 4.5};
  EXPECT_THAT(names_of(twin, "contrast"),
              UnorderedElementsAre("projector.contrast.x.16", "projector.contrast.x.4.5"));
  const Parameter p = named(twin, "projector.contrast.x.4.5");
  EXPECT_EQ(p.start, 1.0);
  EXPECT_EQ(with_change(twin, p, -0.25).fringes.directions[0].contrast,
            (std::vector<double>{1.0, 1.0, 0.75}));
}

TEST(Parameters, PlanesMoveAlongTheirNormalAndTiltAboutTheirPoint) {
  const Twin twin = rich_twin();
  const auto plane_of = [](const Twin& t) { return std::get<PlaneShape>(t.objects[1].shape); };
  const PlaneShape before = plane_of(twin);
  const PlaneShape moved_by = plane_of(with_change(twin, named(twin, "wall.offset_mm"), 0.5));
  EXPECT_LE((moved_by.point_mm - before.point_mm - 0.5 * before.normal).norm(), kRounding);
  EXPECT_LE((moved_by.normal - before.normal).norm(), kRounding);
  Vector3d ways[2];
  for (int i = 0; i < 2; ++i) {
    const PlaneShape tilted =
        plane_of(with_change(twin, named(twin, i == 0 ? "wall.tilt_rad.u" : "wall.tilt_rad.v"), 0.2));
    EXPECT_EQ(tilted.point_mm, before.point_mm);
    EXPECT_NEAR(tilted.normal.norm(), 1.0, kRounding);
    EXPECT_NEAR(tilted.u_axis.norm(), 1.0, kRounding);
    EXPECT_NEAR(tilted.u_axis.dot(tilted.normal), 0.0, kRounding);
    EXPECT_NEAR(std::acos(tilted.normal.dot(before.normal)), std::atan(0.2), 1e-9);
    ways[i] = tilted.normal - tilted.normal.dot(before.normal) * before.normal;
  }
  EXPECT_NEAR(ways[0].dot(ways[1]), 0.0, kRounding);
}

TEST(Parameters, CylindersMoveAcrossTheirAxisAndStayUnit) {
  const Twin twin = rich_twin();
  const auto cylinder_of = [](const Twin& t) { return std::get<CylinderShape>(t.objects[2].shape); };
  const CylinderShape before = cylinder_of(twin);
  for (const char* way : {"u", "v"}) {
    const CylinderShape shifted =
        cylinder_of(with_change(twin, named(twin, std::string("tube.shift_mm.") + way), 0.5));
    EXPECT_NEAR((shifted.point_mm - before.point_mm).norm(), 0.5, kRounding);
    EXPECT_NEAR((shifted.point_mm - before.point_mm).dot(before.axis), 0.0, kRounding);
    const CylinderShape tilted =
        cylinder_of(with_change(twin, named(twin, std::string("tube.tilt_rad.") + way), 0.2));
    EXPECT_NEAR(tilted.axis.norm(), 1.0, kRounding);
    EXPECT_NEAR(std::acos(tilted.axis.dot(before.axis)), std::atan(0.2), 1e-9);
  }
}

TEST(Parameters, AMeshTurnsAboutItsMiddle) {
  const Twin twin = rich_twin();
  const auto world = [](const Twin& t) {
    const auto& shape = std::get<MeshShape>(t.objects[3].shape);
    std::vector<Vector3d> out;
    for (const auto& p : shape.mesh->vertices_mm) out.push_back(shape.T_world_object * p.cast<double>());
    return out;
  };
  const auto middle = [](const std::vector<Vector3d>& points) {
    Vector3d sum = Vector3d::Zero();
    for (const Vector3d& p : points) sum += p;
    return Vector3d(sum / static_cast<double>(points.size()));
  };
  const std::vector<Vector3d> before = world(twin);
  for (int i = 0; i < 3; ++i) {
    const Parameter p = named(twin, std::string("part.turn_rad.") + "xyz"[i]);
    const std::vector<Vector3d> after = world(with_change(twin, p, 0.3));
    EXPECT_LE((middle(after) - middle(before)).norm(), 1e-10);
    const Eigen::Matrix3d R = Eigen::AngleAxisd(0.3, Vector3d::Unit(i)).toRotationMatrix();
    for (std::size_t k = 0; k < before.size(); ++k)
      EXPECT_LE((after[k] - middle(before) - R * (before[k] - middle(before))).norm(), 1e-10) << p.name;
  }
}

TEST(Parameters, AMeshGrowsAboutItsMiddle) {
  const Twin twin = rich_twin();
  const auto mesh_of = [](const Twin& t) { return std::get<MeshShape>(t.objects[3].shape).mesh; };
  const Twin grown = with_change(twin, named(twin, "part.log_scale"), std::log(1.25));
  const Vector3d middle(3.75, 3.75, 6.0);  // of (1, 2, 3), (9, 2, 4), (3, 8, 5), (2, 3, 12)
  const auto& before = mesh_of(twin)->vertices_mm;
  const auto& after = mesh_of(grown)->vertices_mm;
  EXPECT_EQ(before, small_mesh()->vertices_mm);  // the twin keeps its own
  for (std::size_t i = 0; i < before.size(); ++i)
    EXPECT_LE((after[i].cast<double>() - middle - 1.25 * (before[i].cast<double>() - middle)).norm(), 2e-6);
}

TEST(Parameters, AFocalLengthKeepsTheRatioOfItsTwoNumbers) {
  const Twin twin = rich_twin();
  const auto lens = with_change(twin, named(twin, "left.focal_px"), 9.0).cameras[0].lens.intrinsics();
  EXPECT_NEAR(lens[0], 909.0, kRounding);
  EXPECT_NEAR(lens[1], 909.0 * 905.0 / 900.0, kRounding);
  EXPECT_EQ(lens[2], 319.5);
}

TEST(Parameters, WhatOneCameraAloneSeesIsMarked) {
  const Twin twin = rich_twin();
  for (const Parameter& p : all_parameters(twin)) {
    const bool of_left = p.name.starts_with("left."), of_right = p.name.starts_with("right.");
    ASSERT_EQ(p.camera.has_value(), of_left || of_right) << p.name;
    EXPECT_EQ(p.camera.value_or(9), of_left ? 0u : of_right ? 1u : 9u) << p.name;
  }
}

TEST(Parameters, DevicesTurnAboutTheirOwnCentre) {
  const Twin twin = rich_twin();
  for (const char* name : {"projector.turn_rad.x", "projector.turn_rad.y", "projector.turn_rad.z"}) {
    const Twin turned = with_change(twin, named(twin, name), 0.1);
    EXPECT_LE((turned.projector->center_world_mm() - twin.projector->center_world_mm()).norm(), 1e-10);
    EXPECT_NEAR(Eigen::AngleAxisd(turned.projector->T_proj_world.rotation *
                                  twin.projector->T_proj_world.rotation.transpose())
                    .angle(),
                0.1, 1e-9);
  }
}

TEST(Parameters, TheFirstCameraIsTheFrame) {
  for (const std::string& name : names_of(rich_twin(), "rig")) EXPECT_FALSE(name.starts_with("left")) << name;
}

TEST(Parameters, BlurIsFittedAsAVarianceAndShownAsItsRoot) {
  const Twin twin = rich_twin();
  const Parameter p = named(twin, "projector.blur_px");
  EXPECT_NEAR(p.start, 1.5 * 1.5, kRounding);
  EXPECT_NEAR(p.shown(p.start), 1.5, kRounding);
  EXPECT_NEAR(with_change(twin, p, 4.0 - p.start).projector->blur_px, 2.0, kRounding);
  EXPECT_EQ(with_change(twin, p, -p.start).projector->blur_px, 0.0);
  EXPECT_EQ(p.smallest, 0.0);
  // derivative of the root: d sqrt(v) = dv / (2 sqrt(v)); at zero one standard error of v up
  EXPECT_NEAR(p.shown_sigma(4.0, 0.04), 0.01, kRounding);
  EXPECT_NEAR(p.shown_sigma(0.0, 0.04), 0.2, kRounding);
  const Parameter k1 = named(twin, "projector.k1");
  EXPECT_EQ(k1.shown(0.13), 0.13);
  EXPECT_EQ(k1.shown_sigma(0.13, 0.04), 0.04);
}

TEST(Parameters, AChangedPinholeIsADistortedLens) {
  const Twin twin = rich_twin();
  const Parameter p = named(twin, "left.k1");
  EXPECT_EQ(p.start, 0.0);
  const Lens lens = with_change(twin, p, 0.05).cameras[0].lens;
  EXPECT_EQ(lens.model(), "LENSMODEL_OPENCV4");
  ASSERT_EQ(lens.intrinsics().size(), 8u);
  EXPECT_EQ(lens.width(), 640);
  // x = 0.1, y = 0: 900 * 0.1 (1 + 0.05 * 0.01) + 319.5
  const auto q = lens.project({0.1, 0.0, 1.0});
  ASSERT_TRUE(q.has_value());
  EXPECT_NEAR(q->x(), 319.5 + 90.0 * 1.0005, 1e-9);
  EXPECT_NEAR(q->y(), 239.5, 1e-9);
  EXPECT_EQ(with_change(twin, p, 0.0).cameras[0].lens.model(), "LENSMODEL_PINHOLE");
}

TEST(Parameters, AnImpossibleLensIsRefused) {
  const Twin twin = rich_twin();
  EXPECT_THROW(with_change(twin, named(twin, "left.k1"), std::nan("")), UserError);
}

TEST(Parameters, TheReflectivityOfAllLeavesTheDirectLight) {
  const Twin twin = rich_twin(),
             brighter = with_change(twin, named(twin, "bounces.log_albedo"), std::log(1.2));
  for (std::size_t k = 0; k < twin.objects.size(); ++k) {
    EXPECT_NEAR(brighter.objects[k].material.diffuse, 1.2 * twin.objects[k].material.diffuse, kRounding);
    EXPECT_NEAR(brighter.objects[k].material.specular * brighter.projector->intensity,
                twin.objects[k].material.specular * twin.projector->intensity, kRounding);
  }
  EXPECT_NEAR(brighter.projector->intensity * 1.2, twin.projector->intensity, kRounding);
  EXPECT_NEAR(brighter.room.lamp_world.norm() * 1.2, twin.room.lamp_world.norm(), kRounding);
}

TEST(Parameters, TwoChangesAreTheirSum) {
  const Twin twin = rich_twin();
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(-0.02, 0.02);
  for (const Parameter& p : all_parameters(twin)) {
    if (p.is_switch || p.name == "part.log_scale") continue;  // vertices are in single precision
    SCOPED_TRACE(p.name);
    for (int i = 0; i < 5; ++i) {
      const double a = uniform(random), b = uniform(random);
      Twin twice = twin;
      p.change(twice, a);
      p.change(twice, b);
      twice = with_values(twice, {}, Eigen::VectorXd());
      EXPECT_THAT(moved(with_change(twin, p, a + b), twice), ::testing::IsEmpty());
    }
  }
}

TEST(Parameters, OnlyWhatTheTwinHas) {
  Twin twin = rich_twin();
  EXPECT_THAT(names_of(twin, "response"), UnorderedElementsAre("projector.gamma"));
  EXPECT_THAT(names_of(twin, "bounce"), UnorderedElementsAre("bounces"));
  EXPECT_THAT(names_of(twin, "gloss"), UnorderedElementsAre("bounces.glossy"));
  EXPECT_THAT(names_of(twin, "roughness"), UnorderedElementsAre("ball.shininess", "wall.roughness"));
  twin.projector->response = {.kind = ProjectorResponse::Kind::table, .gamma = 1.0, .table = {0.0, 0.4, 1.0}};
  EXPECT_THAT(names_of(twin, "response"), ::testing::IsEmpty());
  twin.cameras[1].vignetting.kind = Vignetting::Kind::cos4;
  EXPECT_THAT(names_of(twin, "vignetting"),
              UnorderedElementsAre("left.vignetting_tilt.x", "left.vignetting_tilt.y", "left.vignetting.a1"));
  twin.objects.resize(1);  // one sphere cannot light itself
  EXPECT_THAT(names_of(twin, "bounce"), ::testing::IsEmpty());
  EXPECT_THAT(names_of(twin, "gloss"), ::testing::IsEmpty());
  EXPECT_THAT(names_of(twin, "pose"),
              UnorderedElementsAre("ball.center_mm.x", "ball.center_mm.y", "ball.center_mm.z"));
  twin.objects[0].material.specular = 0.0;  // no lobe, no width of it
  EXPECT_THAT(names_of(twin, "roughness"), ::testing::IsEmpty());
  twin.projector.reset();
  EXPECT_THAT(names_of(twin, "size"), UnorderedElementsAre("ball.radius_mm"));
  for (const char* group : {"response", "blur", "bounce", "projector_field"})
    EXPECT_THAT(names_of(twin, group), ::testing::IsEmpty()) << group;
}

TEST(Parameters, NamesAreUnique) {
  std::set<std::string> names;
  for (const ParameterGroup& group : parameter_groups())
    for (const Parameter& p : parameters_of(rich_twin(), group.name))
      EXPECT_TRUE(names.insert(p.name).second) << p.name;
}

}  // namespace
}  // namespace fringetwin::compare::parameters_test
