// SPDX-License-Identifier: Apache-2.0
// [[camera]] and [projector] of twin.toml.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "twin/file/cameramodel.hpp"
#include "twin/file/opencv_import.hpp"
#include "twin/file/plain_keys.hpp"
#include "twin/file/twin_file.hpp"
#include "twin/lens/baseline.hpp"
#include "twin/lens/look_at.hpp"
#include "twin/lens/pose_fault.hpp"

namespace fringetwin {
namespace {

/// Where lens and pose come from: a .cameramodel file, an OpenCV calibration, or the twin itself.
const std::vector<std::string> kDeviceKeys = {"model",      "opencv",       "lensmodel",   "imagersize",
                                              "intrinsics", "rt_cam_world", "position_mm", "look_at_mm",
                                              "up",         "baseline_mm",  "angle_deg"};
/// The pose, in two ways of which a device has one.
const std::vector<std::string> kPoseKeys = {"rt_cam_world", "position_mm", "look_at_mm", "up"};

std::vector<std::string> with_device_keys(std::vector<std::string> keys) {
  keys.insert(keys.end(), kDeviceKeys.begin(), kDeviceKeys.end());
  return keys;
}

struct Device {
  Lens lens;
  Pose T_device_world;
};

void refuse_beside(const TomlTable& table, const std::string& source, const std::vector<std::string>& keys) {
  for (const std::string& key : keys)
    if (table.has(key)) table.fail(key, fmt::format("is given beside {}", source), "one of them is enough");
}

Eigen::Vector2i read_imagersize(const TomlTable& table) {
  const auto size = table.vector("imagersize", 2, NumberRange::between(1, 65535));
  if (!size) table.fail("imagersize", "is missing", "it must be [width, height] in px");
  for (int k = 0; k < 2; ++k)
    if ((*size)[k] != std::floor((*size)[k])) table.fail("imagersize", "must be two whole numbers");
  return size->cast<int>();
}

Pose read_look_at(const TomlTable& table) {
  refuse_beside(table, "position_mm", {"rt_cam_world"});
  const auto position = table.vector("position_mm", 3), target = table.vector("look_at_mm", 3),
             up = table.vector("up", 3);
  if (!position)
    table.fail("position_mm", "is missing", "look_at_mm and up need it: where the device stands");
  if (!target) table.fail("look_at_mm", "is missing", "position_mm needs it: a point on the optical axis");
  const auto pose = look_at_pose(*position, *target, up ? Eigen::Vector3d(*up) : kUpByDefault);
  if (pose) return *pose;
  if ((*target - *position).norm() < 1e-3)
    table.fail("look_at_mm", "is where it stands", "it must be another point of the optical axis");
  table.fail("look_at_mm", "is straight above or below, so that no direction of the image is up",
             "give up = [x, y, z], not along the optical axis");
}

/// The world is normally the first camera, so only that one may leave its pose out.
Pose read_pose(const TomlTable& table, bool may_be_world) {
  if (table.has("position_mm") || table.has("look_at_mm") || table.has("up")) return read_look_at(table);
  const auto rt = table.vector("rt_cam_world", 6);
  if (!rt && !may_be_world)
    table.fail("rt_cam_world", "is missing",
               "it must be 6 numbers: rotation vector (rad), then translation (mm), world to this device; or "
               "give position_mm and look_at_mm");
  return rt ? pose_from_rt(RotTrans(*rt)) : Pose{};
}

/// Checks a pose out of a file, after its unit; those of twin.toml are checked where they are read.
void check_pose(const Pose& T, const std::string& where) {
  if (const std::string fault = pose_fault(T); !fault.empty())
    throw UserError(ExitCode::input, where, fault, "check the unit (cameramodel_unit, opencv.unit)");
}

Device read_model_file(const TomlTable& table, const TwinFileContext& context) {
  refuse_beside(table, "model", {"opencv", "lensmodel", "imagersize", "intrinsics"});
  refuse_beside(table, "model", kPoseKeys);
  const std::filesystem::path file = context.resolve(table, "model");
  const CameraModelFile model = read_cameramodel(file);
  context.files->push_back(file);
  RotTrans rt = Eigen::Map<const RotTrans>(model.rt_cam_ref.data());
  rt.tail<3>() *= context.cameramodel_mm_per_unit;
  check_pose(pose_from_rt(rt), file.string());
  return {Lens(model.lensmodel, model.intrinsics, {model.imagersize[0], model.imagersize[1]}, file.string()),
          pose_from_rt(rt)};
}

Device read_opencv(const TomlTable& table, const TwinFileContext& context, bool may_be_world) {
  refuse_beside(table, "opencv", {"lensmodel", "intrinsics"});
  const TomlTable source = *table.table("opencv");
  source.allow({"files", "matrix", "distortion", "rotation", "translation", "unit"});
  const auto names = source.strings("files");
  if (!names || names->empty()) source.fail("files", "must name one file or more");
  std::vector<std::filesystem::path> files;
  for (const std::string& name : *names)
    files.push_back(resolve_path(name, context.folder, source.where("files"), ExitCode::usage));
  OpenCvDevice keys{source.required_string("matrix"), source.required_string("distortion"), "", ""};
  if (source.has("rotation") != source.has("translation"))
    source.fail(source.has("rotation") ? "translation" : "rotation", "is missing", "a pose needs both");
  const double mm_per_unit = source.choice("unit", {"mm", "m"}) == "m" ? 1000.0 : 1.0;
  const bool has_pose = source.has("rotation");
  if (has_pose) {
    refuse_beside(table, "opencv.rotation", kPoseKeys);
    keys.rotation_key = source.required_string("rotation");
    keys.translation_key = source.required_string("translation");
  }
  const OpenCvModel model = import_opencv(files, keys);
  context.files->insert(context.files->end(), files.begin(), files.end());
  RotTrans rt = Eigen::Map<const RotTrans>(model.rt_device_ref.data());
  rt.tail<3>() *= mm_per_unit;
  check_pose(pose_from_rt(rt), table.where("opencv"));
  return {Lens(model.lensmodel, model.intrinsics, read_imagersize(table), table.where("opencv")),
          has_pose ? pose_from_rt(rt) : read_pose(table, may_be_world)};
}

Device read_device(const TomlTable& table, const TwinFileContext& context, bool may_be_world) {
  if (table.has("model")) return read_model_file(table, context);
  if (table.has("opencv")) return read_opencv(table, context, may_be_world);
  if (!table.has("lensmodel") && !table.has("intrinsics"))
    table.fail("", "needs model = \"FILE.cameramodel\", or lensmodel, imagersize and intrinsics");
  const std::string lensmodel = table.required_string("lensmodel");
  const auto intrinsics = table.numbers("intrinsics");
  if (!intrinsics) table.fail("intrinsics", "is missing", "it must be fx fy cx cy, then the distortion");
  const std::string where = fmt::format("{}: {}", table.where("intrinsics"), table.full_key("intrinsics"));
  return {Lens(lensmodel, *intrinsics, read_imagersize(table), where), read_pose(table, may_be_world)};
}

/// Returns the pose of a device after its baseline or angle, where one is given, has moved it.
/// `T_first_world` of the first camera; nullptr: the device is that.
Pose read_placement(const TomlTable& table, const Pose& T_device_world, const Pose* T_first_world) {
  const auto baseline = table.number("baseline_mm", NumberRange::between(1e-3, 1e5));
  const auto angle_deg = table.number("angle_deg", NumberRange::between(0.01, 179.0));
  if (!baseline && !angle_deg) return T_device_world;
  if (baseline) refuse_beside(table, "baseline_mm", {"angle_deg"});
  const std::string key = baseline ? "baseline_mm" : "angle_deg";
  if (!T_first_world)
    table.fail(key, "is a place beside the first camera, and this is that",
               "give it to the projector or to the second camera");
  const auto moved =
      baseline ? with_baseline(*T_first_world, T_device_world, *baseline)
               : with_triangulation(*T_first_world, T_device_world, *angle_deg * std::numbers::pi / 180.0);
  if (moved) return *moved;
  if (baseline)
    table.fail(key, "cannot be reached: both devices stand at one place, or the way ends where this one aims",
               "give its pose with another position");
  table.fail(
      key,
      "needs a point that the device aims at: its optical axis and the first camera's are parallel, or "
      "are nearest to one another behind it, or lie on one line",
      "give baseline_mm, or position_mm and look_at_mm");
}

/// Reads the corners of a curve that is straight, with slope 1, up to the first of them.
CameraResponse read_response_table(const TomlTable& table) {
  CameraResponse response;
  const auto lists = *table.lists_of_rows("table", 2);
  if (lists.size() != 1) table.fail("table", "must be one list of points", "e.g. [[60, 60], [240, 200]]");
  for (const std::vector<double>& point : lists[0]) {
    const CameraResponse::Corner last =
        response.corners.empty() ? CameraResponse::Corner{} : response.corners.back();
    if (!(point[0] > last.in_dn) || !(point[1] > last.out_dn))
      table.fail(
          "table",
          fmt::format("does not rise from [{}, {}] to [{}, {}]", last.in_dn, last.out_dn, point[0], point[1]),
          "each point must lie above the one before, the first above [0, 0]");
    response.corners.push_back({point[0], point[1]});
  }
  if (response.corners.size() < 2) table.fail("table", "must have 2 points or more");
  const CameraResponse::Corner first = response.corners[0], last = response.corners.back(),
                               before = response.corners[response.corners.size() - 2];
  if (std::abs(first.out_dn - first.in_dn) > 1e-9 * first.in_dn)
    table.fail("table", fmt::format("starts with the slope {:.6g}", first.out_dn / first.in_dn),
               "gain_dn is the slope at the origin: divide the light (first column) by that slope, multiply "
               "gain_dn by it; the first point then has two equal numbers");
  response.last_slope = (last.out_dn - before.out_dn) / (last.in_dn - before.in_dn);
  return response;
}

CameraResponse read_camera_response(const TomlTable& sensor) {
  if (!sensor.has("response")) return {};
  if (sensor.is_string("response")) {
    sensor.choice("response", {"linear"});
    return {};
  }
  if (!sensor.is_table("response"))
    sensor.fail("response", "must be \"linear\", { knee_dn = ..., slope = ... } or { table = [...] }");
  const TomlTable table = *sensor.table("response");
  table.allow({"knee_dn", "slope", "table"});
  if (!table.has("table"))
    return knee_response(table.required_number("knee_dn", NumberRange::positive()),
                         table.required_number("slope", NumberRange::positive()));
  if (table.has("knee_dn") || table.has("slope"))
    table.fail("table", "cannot be combined with knee_dn and slope");
  return read_response_table(table);
}

Sensor read_sensor(const TomlTable& table, const TwinFileContext& context) {
  table.allow(names_of_keys<Sensor>());
  Sensor sensor;
  read_plain_keys(table, sensor);
  sensor.black_level_dn =
      table.number_or("black_level_dn", sensor.black_level_dn, NumberRange::between(0.0, sensor.max_dn()));
  sensor.black_level_is_stated = table.has("black_level_dn");
  sensor.response = read_camera_response(table);
  if (table.has("prnu")) sensor.prnu.file = context.resolve(table, "prnu");
  if (table.has("dsnu")) sensor.dsnu.file = context.resolve(table, "dsnu");
  return sensor;
}

Optics read_optics(const TomlTable& table) {
  table.allow({"f_number", "focal_length_mm", "focus_distance_mm"});
  Optics optics{.f_number = table.required_number("f_number", NumberRange::positive()),
                .focal_length_mm = table.required_number("focal_length_mm", NumberRange::positive()),
                .focus_distance_mm = table.required_number("focus_distance_mm", NumberRange::positive())};
  if (optics.focus_distance_mm <= optics.focal_length_mm)
    table.fail("focus_distance_mm", fmt::format("must be > focal_length_mm = {}, is {}",
                                                optics.focal_length_mm, optics.focus_distance_mm));
  return optics;
}

/// Refuses a factor that is not positive everywhere in the image: nothing could be seen there.
void check_vignetting(const TomlTable& camera, const char* key, const Vignetting& v) {
  const double tilt = std::hypot(v.tilt[0], v.tilt[1]);  // the worst direction
  for (int i = 0; i <= 100; ++i) {
    const double s = 0.01 * i;  // r^2
    if (1.0 - tilt * std::sqrt(s) + s * (v.a[0] + s * (v.a[1] + s * v.a[2])) <= 0.0)
      camera.fail(key,
                  fmt::format("1 + a1 r^2 + a2 r^4 + a3 r^6{} is not positive at r = {:.2f}",
                              tilt > 0.0 ? " with the tilt" : "", std::sqrt(s)),
                  "r is 1 at the image's corners");
  }
}

Vignetting read_vignetting(const TomlTable& camera) {
  Vignetting v;
  if (const auto tilt = camera.numbers("vignetting_tilt")) {
    if (tilt->size() != 2) camera.fail("vignetting_tilt", "must have 2 numbers, to the right and down");
    v.kind = Vignetting::Kind::polynomial;
    v.tilt = {(*tilt)[0], (*tilt)[1]};
    if (camera.is_string("vignetting"))
      camera.fail("vignetting_tilt", "goes with three coefficients or alone, not with a word");
    check_vignetting(camera, "vignetting_tilt", v);
  }
  if (!camera.has("vignetting")) return v;
  if (camera.is_string("vignetting")) {
    if (camera.choice("vignetting", {"none", "cos4"}) == "cos4") v.kind = Vignetting::Kind::cos4;
    return v;
  }
  if (!camera.is_array("vignetting"))
    camera.fail("vignetting", "must be \"none\", \"cos4\" or three coefficients [a1, a2, a3]");
  const Eigen::Vector3d a = *camera.vector("vignetting", 3);
  v.kind = Vignetting::Kind::polynomial;
  v.a = {a[0], a[1], a[2]};
  check_vignetting(camera, "vignetting", v);
  return v;
}

/// Reads which colour of a colour sensor the camera's image is; the lens, read before, is of the whole
/// sensor.
void read_channel(const TomlTable& sensor, Camera& camera) {
  const auto mosaic = sensor.choice("mosaic", mosaic_names());
  const auto colour = sensor.choice("channel", mosaic_colour_names());
  if (!mosaic && !colour) return;
  if (!mosaic)
    sensor.fail("mosaic", "is missing",
                "channel needs it: the filters of the sensor's first four pixels, e.g. \"RGGB\"");
  if (!colour)
    sensor.fail("channel", "is missing",
                "mosaic needs it: the colour whose pixels are the camera's image, e.g. \"green\"");
  MosaicChannel channel{*mosaic, *mosaic_colour(*colour), {camera.lens.width(), camera.lens.height()}};
  if (channel.sensor_px.x() < 2 || channel.sensor_px.y() < 2)
    sensor.fail("mosaic", "needs an imagersize of 2 x 2 px or more");
  camera.lens = image_lens(camera.lens, channel, "the lens of the image of camera " + camera.name);
  camera.channel = std::move(channel);
}

/// `T_first_world`: of the first camera; nullptr: this is that.
Camera read_camera(const TomlTable& table, const TwinFileContext& context, const Pose* T_first_world) {
  table.allow(with_device_keys(names_of_keys<Camera>()));
  const std::string name = table.required_name();
  const Device device = read_device(table, context, T_first_world == nullptr);
  Camera camera{name, device.lens, read_placement(table, device.T_device_world, T_first_world), {}, {}};
  if (const auto sensor = table.table("sensor")) {
    camera.sensor = read_sensor(*sensor, context);
    read_channel(*sensor, camera);
  }
  if (const auto optics = table.table("optics")) camera.optics = read_optics(*optics);
  read_plain_keys(table, camera);
  camera.vignetting = read_vignetting(table);
  if (table.has("texture"))
    camera.texture_file = context.resolve(table, "texture");
  else if (camera.texture_spread_px > 0.0)
    table.fail("texture_spread_px", "has no effect without a texture",
               "give texture = \"FILE.exr\", the factors of the pixels, or leave it out");
  return camera;
}

ProjectorResponse read_response(const TomlTable& projector) {
  ProjectorResponse response;
  if (!projector.has("response")) return response;
  if (projector.is_string("response")) {
    projector.choice("response", {"linear"});
    return response;
  }
  if (!projector.is_table("response"))
    projector.fail("response", "must be \"linear\", { gamma = ... } or { table = [...] }");
  const TomlTable table = *projector.table("response");
  table.allow({"gamma", "table"});
  if (table.has("gamma") == table.has("table"))
    projector.fail("response", "must have either gamma or table", "e.g. { gamma = 2.2 }");
  if (table.has("gamma")) {
    response.kind = ProjectorResponse::Kind::gamma;
    response.gamma = *table.number("gamma", NumberRange::positive());
  } else {
    response.kind = ProjectorResponse::Kind::table;
    response.table = *table.numbers("table", NumberRange::between(0.0, 1.0));
    if (response.table.size() < 2) table.fail("table", "must have 2 levels or more");
  }
  return response;
}

/// Refuses keys of the raster of the projector's image that cannot go with the others.
void check_pixels(const TomlTable& table, const Projector& projector) {
  for (const char* key : {"pixel_fill", "quantise_bits"})
    if (!projector.pixel_structure && table.has(key))
      table.fail(key, "has no effect without pixel_structure = true");
  if (projector.optics && projector.pixel_fill < 1.0)
    table.fail("pixel_fill", "below 1 cannot be combined with [projector.optics]",
               "describe the blur of the gaps by blur_px");
}

/// Reads the field of the blur and refuses what it cannot go with.
void read_blur_field(const TomlTable& table, Projector& projector) {
  static const std::string key = "blur_field_px2";
  const auto field = table.vector(key, 5);
  if (!field) return;
  std::copy_n(field->data(), 5, projector.blur_field_px2.begin());
  if (!projector.has_blur_field()) return;
  if (projector.pixel_structure || projector.optics)
    table.fail(key, "cannot be combined with pixel_structure or [projector.optics]");
  if (!(projector.least_blur_px() > 0.0))
    table.fail(
        key,
        fmt::format("leaves no blur somewhere in the projector's image: blur_px^2 = {:.6g} is too small",
                    projector.blur_px * projector.blur_px),
        "the variance must be positive everywhere");
}

/// Reads the tails of the point spread and refuses what they cannot go with.
void read_halo(const TomlTable& table, Projector& projector) {
  static const std::string key = "halo";
  const auto lists = table.lists_of_rows(key, 2, NumberRange::between(0.0, kWidestHaloPx));
  if (!lists || lists->empty()) return;
  if (lists->size() > 1) table.fail(key, "has lists within lists", "write [[share, sigma_px], ...]");
  const std::vector<std::vector<double>>* rows = &lists->front();
  if (rows->size() > kMostHalos)
    table.fail(key, fmt::format("has {} parts", rows->size()), fmt::format("give {} at most", kMostHalos));
  double sum = 0.0;
  for (const std::vector<double>& row : *rows) {
    projector.halo.push_back({.share = row[0], .sigma_px = row[1]});
    sum += row[0];
  }
  constexpr double kRounding = 1e-9;  // of 0.34 + 0.55 + 0.11
  if (sum > 1.0 + kRounding)
    table.fail(key, fmt::format("has shares of the light whose sum is {:.6g}", sum),
               "write [[share, sigma_px], ...] with shares that are parts of 1");
  if (!projector.has_halo()) return;
  if (!(projector.blur_px > 0.0))
    table.fail(key, "goes with a blur, and there is none",
               "give blur_px: what spreads the rest of the light");
  if (projector.pixel_structure && projector.pixel_fill < 1.0)
    table.fail(key, "cannot be combined with gaps between the projector's pixels (pixel_fill below 1)",
               "describe the blur of the gaps by blur_px");
}

/// Reads the field of the light: complete orders of terms.
void read_light_field(const TomlTable& table, Projector& projector) {
  static const std::string key = "light_field";
  constexpr double kMost = 50.0;  // of an exponent: beyond, single precision ends
  const auto field = table.numbers(key, NumberRange::between(-kMost, kMost));
  if (!field) return;
  constexpr std::size_t kComplete[] = {2, 5, 9, kLightFieldTerms.size()};
  if (std::ranges::find(kComplete, field->size()) == std::end(kComplete))
    table.fail(key, fmt::format("has {} numbers", field->size()),
               "give 2, 5, 9 or 14: all terms up to the first, second, third or fourth order");
  double sum = 0.0;
  for (const double c : *field) sum += std::abs(c);
  if (sum > kMost)
    table.fail(key, fmt::format("has numbers whose sizes add up to {:.4g}", sum),
               fmt::format("keep that sum below {:g}: the light is exp of up to so much", kMost));
  projector.light_field = *field;
}

}  // namespace

std::vector<Camera> read_cameras(const TomlTable& root, const TwinFileContext& context) {
  const std::vector<TomlTable> tables = root.tables("camera");
  if (tables.empty()) root.fail("camera", "is missing", "a twin needs one [[camera]] or two");
  if (tables.size() > 2)
    tables[2].fail("", fmt::format("is one camera too many: {} are given", tables.size()),
                   "a twin has one or two");
  std::vector<Camera> cameras;
  for (const TomlTable& table : tables) {
    cameras.push_back(read_camera(table, context, cameras.empty() ? nullptr : &cameras[0].T_cam_world));
    if (cameras.size() == 2 && cameras[0].name == cameras[1].name)
      table.fail("name", fmt::format("\"{}\" is the name of the first camera, too", cameras[1].name));
  }
  return cameras;
}

std::optional<Projector> read_projector(const TomlTable& root, const TwinFileContext& context,
                                        const Pose& T_first_world) {
  const auto table = root.table("projector");
  if (!table) return std::nullopt;
  table->allow(with_device_keys(names_of_keys<Projector>()));
  const Device device = read_device(*table, context, false);
  Projector projector{.lens = device.lens,
                      .T_proj_world = read_placement(*table, device.T_device_world, &T_first_world),
                      .response = read_response(*table)};
  read_plain_keys(*table, projector);
  projector.inverse_square = table->choice("falloff", {"none", "inverse-square"}) == "inverse-square";
  if (projector.inverse_square)
    projector.reference_distance_mm =
        table->required_number("reference_distance_mm", NumberRange::positive());
  else if (table->has("reference_distance_mm"))
    table->fail("reference_distance_mm", "has no effect without falloff = \"inverse-square\"");
  if (const auto optics = table->table("optics")) projector.optics = read_optics(*optics);
  check_pixels(*table, projector);
  read_blur_field(*table, projector);
  read_halo(*table, projector);
  read_light_field(*table, projector);
  return projector;
}

}  // namespace fringetwin
