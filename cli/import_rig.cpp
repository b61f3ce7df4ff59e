// SPDX-License-Identifier: Apache-2.0
#include "cli/import_rig.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "calib/import/check_import.hpp"
#include "calib/import/swapped_size.hpp"
#include "cli/option_groups.hpp"
#include "cli/option_values.hpp"
#include "cli/start/starting_twin.hpp"
#include "report/text.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/paths.hpp"
#include "twin/base/progress.hpp"
#include "twin/file/cameramodel.hpp"
#include "twin/image/image_io.hpp"
#include "twin/lens/lens.hpp"
#include "twin/lens/pose_fault.hpp"

namespace fringetwin::cli {
namespace {

constexpr double kMetresPerMm = 1e-3;  // mrcal's convention: .cameramodel files in metres
constexpr const char* kForward = "device-from-ref";
constexpr const char* kBackward = "ref-from-device";

/// One line a convention on stdout; the sentence when the poses do not fit as given.
void check_observations(const ImportedRig& rig, const RigOptions& o) {
  if (rig.devices.size() < 2)
    throw UserError(ExitCode::usage, "--check", "one device alone has no R, T to check");
  const auto seen = calib::read_correspondences(o.check, rig.devices);
  std::string fault, hint;
  for (const auto& check : calib::check_poses(rig.devices, seen, o.check_max_px)) {
    for (const auto& fit : check.fits)
      fmt::print(
          "{}: R, T {}: {:.3g} px from the epipolar lines, {:.0f} % in front, reprojection {}\n",
          check.device, calib::convention_name(fit.convention), fit.epipolar_px, 100.0 * fit.in_front,
          std::isfinite(fit.reprojection_px) ? fmt::format("{:.3g} px rms", fit.reprojection_px) : "-");
    const auto& given = check.fits.front();
    const auto& best = check.fits[static_cast<std::size_t>(check.best)];
    if (!fault.empty() || (check.fits_any && check.best == calib::PoseConvention::as_given)) continue;
    if (check.fits_any) {
      fault = fmt::format(
          "{}: R, T fit the observations {} ({:.2g} px; as given {:.2g} px, {:.0f} % in front)", check.device,
          calib::convention_name(check.best), best.epipolar_px, given.epipolar_px, 100.0 * given.in_front);
      hint = check.best == calib::PoseConvention::inverted
                 ? fmt::format("import with --poses {}", o.poses == kForward ? kBackward : kForward)
                 : "mend the file";
    } else {
      fault =
          fmt::format("{}: R, T fit the {} observations in no way (as given {:.3g} px, {:.0f} % in front)",
                      check.device, check.n, given.epipolar_px, 100.0 * given.in_front);
      hint = "are the columns in the order of the devices, and the calibration of this rig?";
    }
  }
  if (!fault.empty()) throw UserError(ExitCode::input, o.check, fault, hint);
}

void write_model(const std::filesystem::path& file, const calib::ImportedDevice& device,
                 const std::string& source) {
  CameraModelFile out{.lensmodel = device.lensmodel, .intrinsics = device.intrinsics};
  const RotTrans rt = rt_from_pose(device.T_device_ref);
  for (std::size_t i = 0; i < 6; ++i)
    out.rt_cam_ref[i] = rt[static_cast<Eigen::Index>(i)] * (i < 3 ? 1.0 : kMetresPerMm);
  out.imagersize = device.imagersize_px;
  out.comments = {" imported by fringetwin from " + source, " translation in metres"};
  out.extra = device.extra;
  write_cameramodel(file, out);
}

}  // namespace

ImportedRig read_models(std::vector<std::string> files, const std::string& projector, double mm_per_unit) {
  ImportedRig rig;
  rig.has_projector = !projector.empty();
  if (rig.has_projector) files.push_back(projector);
  rig.source = fmt::format("{}", fmt::join(files, " "));
  for (const std::string& file : files) {
    const CameraModelFile model = read_cameramodel(file);
    RotTrans rt = Eigen::Map<const RotTrans>(model.rt_cam_ref.data());
    rt.tail<3>() *= mm_per_unit;
    rig.devices.push_back({std::filesystem::path(file).stem().string(), model.lensmodel, model.intrinsics,
                           model.imagersize, pose_from_rt(rt), model.extra, file});
  }
  return rig;
}

void check_devices(const ImportedRig& rig) {
  const std::size_t n_cameras = rig.devices.size() - (rig.has_projector ? 1 : 0);
  if (n_cameras < 1 || n_cameras > 2)
    throw UserError(ExitCode::usage, rig.source, fmt::format("has {} cameras", n_cameras),
                    "a twin has one camera or two");
  for (std::size_t i = 0; i < rig.devices.size(); ++i) {
    const calib::ImportedDevice& d = rig.devices[i];
    if (const std::string fault = name_fault(d.name); !fault.empty())
      throw UserError(ExitCode::usage, d.where, "the name " + fault, kNameHint);
    if (const std::string fault = pose_fault(d.T_device_ref); !fault.empty())
      throw UserError(ExitCode::input, d.where, fault, "check the numbers and --unit");
    if (const std::string doubt = calib::swapped_size_doubt(d); !doubt.empty()) warn(doubt);
    // Refuses a lens that does not invert, before anything is written.
    (void)Lens(d.lensmodel, d.intrinsics, {d.imagersize_px[0], d.imagersize_px[1]}, d.where);
    for (std::size_t k = 0; k < i; ++k) {
      const calib::ImportedDevice& other = rig.devices[k];
      if (other.name == d.name)
        throw UserError(ExitCode::usage, d.where, fmt::format("another device is named \"{}\", too", d.name),
                        "give each device a name of its own");
      const Pose between = d.T_device_ref * other.T_device_ref.inverse();
      if (between.translation_mm.norm() < 1e-6)
        warn(d.name + " stands in the same place as " + other.name + "; is its R, T right?");
    }
  }
}

void add_rig_options(CLI::App& sub, RigOptions& options) {
  begin_group(sub, kOutput);
  sub.add_option("--out", options.out, "Folder for the .cameramodel files and twin.toml")->type_name("DIR");
  begin_group(sub, "Poses");
  sub.add_option("--check", options.check,
                 "Observations of the same points (.vnl corner file, or a table of two columns per device): "
                 "says which way R, T fit, and refuses when it is not as given")
      ->type_name("FILE");
  sub.add_option("--check-max-px", options.check_max_px,
                 "Largest rms distance from the epipolar lines that fits, px")
      ->type_name("PX")
      ->capture_default_str();
  sub.add_option("--poses", options.poses,
                 "What R, T of the files map: device-from-ref (x_device = R x_ref + T), or ref-from-device")
      ->type_name("NAME")
      ->check(CLI::IsMember({kForward, kBackward}))
      ->capture_default_str();
  begin_group(sub, kInput);
}

void check_rig_options(const RigOptions& o) {
  if (o.out.empty() && o.check.empty())
    throw UserError(ExitCode::usage, "import", "needs --out (or --check)",
                    "give a folder for the models: --out RIG");
  if (!o.out.empty()) check_out_folder(o.out);
}

DeviceRequest parse_device(const std::string& option, const std::string& text, const std::string& example) {
  const auto fail = [&](const std::string& what) -> UserError {
    return UserError(ExitCode::usage, option + " " + text, what, "write " + example);
  };
  const auto equals = text.find('=');
  const auto at = text.rfind('@');
  if (equals == std::string::npos || at == std::string::npos || at < equals) throw fail("cannot be read");
  DeviceRequest request;
  request.option = option + " " + text;
  request.name = text.substr(0, equals);
  if (const std::string fault = name_fault(request.name); !fault.empty())
    throw UserError(ExitCode::usage, request.option, "the name " + fault, kNameHint);
  request.parts = split_list(text.substr(equals + 1, at - equals - 1));
  const std::optional<std::array<int, 2>> size = parse_size(text.substr(at + 1));
  if (!size) throw fail("the image size cannot be read");
  request.imagersize = *size;
  return request;
}

std::vector<DeviceRequest> parse_devices(const std::vector<std::string>& cameras,
                                         const std::string& projector, const std::string& example) {
  std::vector<DeviceRequest> requests;
  requests.reserve(cameras.size() + 1);
  for (const auto& text : cameras) requests.push_back(parse_device("--camera", text, example));
  if (requests.size() > 2)
    throw UserError(ExitCode::usage, "--camera", fmt::format("is given {} times", requests.size()),
                    "a twin has one camera or two");
  if (!projector.empty()) {
    requests.push_back(parse_device("--projector", "projector=" + projector, example));
    requests.back().option = "--projector " + projector;
  }
  for (std::size_t i = 0; i < requests.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (requests[k].name == requests[i].name)
        throw UserError(
            ExitCode::usage, requests[i].option,
            fmt::format("{0}.cameramodel would be written twice: an earlier --camera is named \"{0}\", too",
                        requests[i].name),
            "give each camera a name of its own, other than \"projector\"");
  return requests;
}

int finish_import(ImportedRig rig, const RigOptions& o) {
  check_rig_options(o);
  if (o.poses == kBackward)
    for (calib::ImportedDevice& d : rig.devices) {
      d.T_device_ref = d.T_device_ref.inverse();
      d.extra.clear();  // what mrcal keeps beside a pose is of the pose as it was
    }
  check_devices(rig);
  if (!o.check.empty()) check_observations(rig, o);
  if (o.out.empty()) return static_cast<int>(ExitCode::ok);
  begin_output(o.out, {"twin.toml"});
  std::vector<StartingDevice> devices;
  for (const calib::ImportedDevice& device : rig.devices) {
    write_model(std::filesystem::path(o.out) / (device.name + ".cameramodel"), device, rig.source);
    devices.push_back(
        {device.name, device.imagersize_px[0], rig.has_projector && &device == &rig.devices.back()});
  }
  const std::filesystem::path twin = std::filesystem::path(o.out) / "twin.toml";
  write_text_file(twin, starting_twin_toml("imported rig", devices));
  say(fmt::format("wrote {} model file(s) and twin.toml to {}", rig.devices.size(), o.out));
  say("next: say in it what is projected and what to fit, then: " +
      report::shell_command({"fringetwin", "measure", twin.string(), "--captures", "CAPTURES", "--out",
                             (std::filesystem::path(o.out) / "measured").string()}));
  return static_cast<int>(ExitCode::ok);
}

}  // namespace fringetwin::cli
