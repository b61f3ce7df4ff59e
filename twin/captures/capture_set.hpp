// SPDX-License-Identifier: Apache-2.0
// A capture set: capture.toml and its images (docs/formats/captures.md). Real and simulated captures are the
// same.
#pragma once
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "twin/fringes.hpp"
#include "twin/image/gray_image.hpp"
#include "twin/image/image.hpp"
#include "twin/image/image_io.hpp"
#include "twin/twin.hpp"

namespace fringetwin {

struct CaptureCamera {
  std::string name;
  std::vector<std::filesystem::path> files;  ///< absolute, sequence order
  std::optional<std::filesystem::path> white, black;
  /// Exposure of the Gray-code images relative to the phase steps; nullopt = the same (1.0 in the
  /// file is the same, too); NaN = "different", unknown.
  std::optional<double> gray_code_exposure;
  std::string pattern;                ///< with the folder, when the file has one; for messages
  std::optional<int> images_on_disk;  ///< pattern form: images without a gap from number 0
};

struct CaptureSet {
  std::filesystem::path file;  ///< the capture.toml
  std::vector<CaptureCamera> cameras;
  std::optional<ColourChannel> channel = {};      ///< that is taken of colour images; gray ones stay
  std::map<std::string, std::string> provenance;  ///< flattened, "a.b" = "text"
  const CaptureCamera* find(const std::string& camera) const;
};

/// A gray value below full scale at which a sensor stops (clip.hpp).
struct Clip {
  double dn = 0.0;      ///< values at or above are saturated
  std::uint64_t n = 0;  ///< how many of the phase steps' values are
};

/// One camera's images in memory, sequence order, in DN (or irradiance for EXR sets).
struct CameraImages {
  std::string camera = {};
  std::vector<GrayImage> images = {};  ///< whole numbers in as few bytes as hold them
  std::optional<GrayImage> white = {}, black = {};
  int bit_depth = 8;
  bool radiance = false;  ///< EXR: value = E, no saturation, no quantisation
  std::optional<double> gray_code_exposure = {};
  std::optional<Clip> clip = {};  ///< where the values stop below full scale; set when the images are loaded
  /// Values at or above are saturated (the clip, else 2^bit_depth - 1; +inf for radiance).
  double saturation_dn() const {
    if (radiance) return std::numeric_limits<double>::infinity();
    return clip ? clip->dn : static_cast<double>((1 << bit_depth) - 1);
  }
};

/// Reads DIR/capture.toml (unknown keys are errors). `n_images` = length of the sequence, needed to
/// expand a `pattern = "left/%04d.png"`; without it a pattern has the images on disk, those of
/// images_on_disk (stored_images.hpp).
CaptureSet read_capture_set(const std::filesystem::path& dir, std::optional<int> n_images = {});

/// Every file that the set names, and itself.
std::vector<std::filesystem::path> files_of(const CaptureSet& set);

/// The size of an image of this camera; of a colour sensor's channel, also that of the whole sensor.
RightSize right_size(const Camera& camera);
/// Returns the camera's image: of an image of the whole colour sensor the pixels of its channel, else as it
/// is.
ImageF image_of_camera(ImageF image, const Camera& camera);
/// Reads a gray image of this camera, of right_size(). Throws as read_gray().
LoadedGray read_camera_gray(const std::filesystem::path& file, const Camera& camera,
                            const std::optional<ColourChannel>& channel = {});

/// Loads one camera's images. Throws UserError(input) naming the image for: missing, truncated or
/// undecodable file, wrong size (both sizes named), colour image of a set without a channel, wrong count
/// (both counts named), a 16-bit value above the sensor's range, an irradiance that is none. Finds where the
/// values stop below full scale.
CameraImages load_camera_images(const CaptureSet& set, const Camera& camera, const Fringes& fringes);

/// Writes images as <camera>/0000.png … (8-bit PNG for bit_depth 8, else 16-bit), in parallel, each to
/// a temporary name first. White/black as <camera>/white.png, black.png. Higher numbers left by an
/// earlier, longer sequence are removed: a pattern in capture.toml names every number on disk.
void write_camera_images(const std::filesystem::path& dir, const CameraImages& images);
/// Writes <camera>/0000.exr … float32, channel Y.
void write_camera_radiance(const std::filesystem::path& dir, const CameraImages& images);
/// One [[camera]] as it stands in capture.toml.
struct CaptureEntry {
  std::string name;
  std::string pattern = {};             ///< or
  std::vector<std::string> files = {};  ///< relative to root
  std::string root = ".";               ///< relative to capture.toml
  std::optional<std::string> white = {}, black = {};
  std::optional<double> gray_code_exposure = {};  ///< as in CaptureCamera
};
/// Writes capture.toml, sealed (twin/base/seal.hpp). Call it last: it says that the images are there.
void write_capture_toml(const std::filesystem::path& dir, const std::vector<CaptureEntry>& cameras,
                        const std::map<std::string, std::string>& provenance,
                        const std::optional<ColourChannel>& channel = {});
/// Writes the capture.toml that describes what write_camera_images() or write_camera_radiance() wrote.
/// extension "png" or "exr". `root`: the folder that holds <camera>/, relative to `dir`
/// (".." for a capture.toml in a sub-folder that describes the EXR images beside the PNG).
void write_capture_toml(const std::filesystem::path& dir, const std::vector<const CameraImages*>& cameras,
                        const std::map<std::string, std::string>& provenance, const std::string& extension,
                        const std::string& root = ".");

}  // namespace fringetwin
