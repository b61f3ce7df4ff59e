// SPDX-License-Identifier: Apache-2.0
// Checks and writes the devices that an `import` has read, and holds the options that every import has.
#pragma once
#include <string>
#include <vector>

#include "calib/import/imported_rig.hpp"

namespace CLI {
class App;
}

namespace fringetwin::cli {

struct RigOptions {
  std::string out;
  std::string check;  ///< observations to check the poses with
  double check_max_px = 3.0;
  std::string poses = "device-from-ref";  ///< or "ref-from-device": R, T of the files are to be inverted
};

/// Adds --out --check --check-max-px --poses
void add_rig_options(CLI::App& sub, RigOptions& options);

/// Checks them before anything is read: throws UserError(usage) for neither --out nor --check, and for a
/// folder that cannot be written.
void check_rig_options(const RigOptions& options);

/// The devices of one import; the projector, if there is one, last.
struct ImportedRig {
  std::vector<calib::ImportedDevice> devices;
  bool has_projector = false;
  std::string source;  ///< for the comment in the files
};

/// Returns the devices of mrcal's models, each named for its file; `files`: the cameras', to which the
/// projector's (may be empty) is added.
ImportedRig read_models(std::vector<std::string> files, const std::string& projector, double mm_per_unit);

/// Throws UserError(usage) for lenses that do not invert, two devices of one name, more than two cameras;
/// warns of two devices in one place.
void check_devices(const ImportedRig& rig);

/// NAME=PART,PART...[@WIDTHxHEIGHT], as --camera and --projector take them.
struct DeviceRequest {
  std::string name;
  std::vector<std::string> parts;
  std::array<int, 2> imagersize{};
  std::string option;  ///< as typed, for messages
};
DeviceRequest parse_device(const std::string& option, const std::string& text, const std::string& example);

std::vector<DeviceRequest> parse_devices(const std::vector<std::string>& cameras,
                                         const std::string& projector, const std::string& example);

/// Checks and writes the rig. Throws UserError(usage) for lenses that do not invert, two devices in one place
/// or of one name, more than two cameras. With --check prints how each pose fits and throws UserError(input)
/// when it does not as given. With --out writes the .cameramodel files and, last, twin.toml. Returns the exit
/// code.
int finish_import(ImportedRig rig, const RigOptions& options);

}  // namespace fringetwin::cli
