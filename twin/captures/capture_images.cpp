// SPDX-License-Identifier: Apache-2.0
// The images of a capture set: loaded with every check of capture_set.hpp, written in parallel.
#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "twin/base/errors.hpp"
#include "twin/base/parallel.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/captures/clip.hpp"
#include "twin/captures/load_images.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin {
namespace fs = std::filesystem;
namespace {

void check_count(const CaptureSet& set, const CaptureCamera& source, std::size_t n_sequence) {
  const std::string camera = fmt::format("camera \"{}\"", source.name);
  if (source.files.size() != n_sequence)
    throw UserError(
        ExitCode::input, set.file.string(),
        fmt::format("{} lists {} images, the sequence has {}", camera, source.files.size(), n_sequence),
        "check steps, pitches and Gray code in [fringes]");
  if (!source.images_on_disk || *source.images_on_disk == static_cast<int>(n_sequence)) return;
  const int on_disk = *source.images_on_disk;
  if (on_disk > static_cast<int>(n_sequence))
    throw UserError(ExitCode::input, source.pattern,
                    fmt::format("{} has {} images on disk, the sequence has {}", camera, on_disk, n_sequence),
                    "check steps, pitches and Gray code in [fringes], or list the images: files = [...]");
  const auto missing = std::ranges::find_if(source.files, [](const fs::path& file) {
    std::error_code error;
    return !fs::exists(file, error);
  });
  if (missing == source.files.end())
    throw UserError(
        ExitCode::input, source.pattern,
        fmt::format("{} has its white or black image among the {} of the sequence", camera, n_sequence),
        "list the images: files = [...]");
  throw UserError(
      ExitCode::input, missing->string(),
      fmt::format("no such image; {} has {} images without a gap from number 0, the sequence has {}", camera,
                  on_disk, n_sequence));
}

ImageF load_dn(const fs::path& file, const Camera& camera, const std::optional<ColourChannel>& channel) {
  LoadedGray gray = read_camera_gray(file, camera, channel);
  const int bit_depth = camera.sensor.bit_depth;
  if (gray.file_bits == 8 && bit_depth > 8)
    throw UserError(ExitCode::input, file.string(),
                    fmt::format("holds 8 bit values, the sensor of camera \"{}\" has bit_depth = {}",
                                camera.name, bit_depth),
                    "saturation would go unseen: set bit_depth = 8 or give the images as 16 bit");
  const auto max_dn = static_cast<float>(camera.sensor.max_dn());
  const auto above = std::ranges::find_if(gray.image.data, [&](float v) { return v > max_dn; });
  if (above != gray.image.data.end()) {
    const auto index = static_cast<int>(above - gray.image.data.begin());
    throw UserError(ExitCode::input, file.string(),
                    fmt::format("value {} at pixel ({}, {}) is above the {} of a {} bit sensor", *above,
                                index % gray.image.width, index / gray.image.width, max_dn, bit_depth),
                    "check bit_depth, or shift the values down to the low bits");
  }
  return std::move(gray.image);
}

ImageF load_image(const fs::path& file, const Camera& camera, bool radiance,
                  const std::optional<ColourChannel>& channel) {
  return radiance ? image_of_camera(read_irradiance(file, right_size(camera)), camera)
                  : load_dn(file, camera, channel);
}

fs::path image_file(const fs::path& dir, const std::string& camera, int number, const char* extension) {
  return dir / camera / fmt::format("{:04d}.{}", number, extension);
}

/// A shorter sequence written over a longer one leaves no old image that the pattern would still name.
void remove_later_images(const fs::path& dir, const std::string& camera, int first, const char* extension) {
  std::error_code error;
  for (int number = first; fs::remove(image_file(dir, camera, number, extension), error); ++number) {
  }
}

void write_all(const fs::path& dir, const CameraImages& images, const char* extension,
               const std::function<void(const fs::path&, const ImageF&)>& write) {
  const int n = static_cast<int>(images.images.size());
  for_each_parallel(n, [&](int i) {
    write(image_file(dir, images.camera, i, extension), images.images[static_cast<std::size_t>(i)].floats());
  });
  if (images.white) write(dir / images.camera / fmt::format("white.{}", extension), images.white->floats());
  if (images.black) write(dir / images.camera / fmt::format("black.{}", extension), images.black->floats());
  remove_later_images(dir, images.camera, n, extension);
}

}  // namespace

bool has_radiance(const CaptureCamera& source) { return is_exr_name(source.files.front()); }

LoadedImages load_images(const CaptureCamera& source, const std::function<ImageF(const fs::path&)>& load) {
  const bool radiance = has_radiance(source);
  const auto load_one = [&](const fs::path& file) {
    if (is_exr_name(file) != radiance)
      throw UserError(ExitCode::input, file.string(),
                      "a capture set has either EXR images (irradiance) or gray images, not both");
    return GrayImage::packed(load(file));
  };
  LoadedImages loaded;
  loaded.images.resize(source.files.size());
  for_each_parallel(static_cast<int>(source.files.size()), [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    loaded.images[k] = load_one(source.files[k]);
  });
  if (source.white) loaded.white = load_one(*source.white);
  if (source.black) loaded.black = load_one(*source.black);
  return loaded;
}

RightSize right_size(const Camera& camera) {
  RightSize right{camera.lens.width(), camera.lens.height(), fmt::format("camera \"{}\"", camera.name),
                  "check imagersize"};
  if (!camera.channel) return right;
  right.of = fmt::format("channel \"{}\" of camera \"{}\"", name_of(camera.channel->colour), camera.name);
  right.or_width = camera.channel->sensor_px.x();
  right.or_height = camera.channel->sensor_px.y();
  return right;
}

ImageF image_of_camera(ImageF image, const Camera& camera) {
  const auto& channel = camera.channel;
  const bool is_whole =
      channel && image.width == channel->sensor_px.x() && image.height == channel->sensor_px.y();
  return is_whole ? channel_image(image, *channel) : std::move(image);
}

LoadedGray read_camera_gray(const fs::path& file, const Camera& camera,
                            const std::optional<ColourChannel>& channel) {
  if (camera.channel && channel)
    throw UserError(
        ExitCode::input, file.string(),
        fmt::format("is taken for the colour \"{}\" of a colour image, camera \"{}\" has the pixels of a raw "
                    "mosaic",
                    colour_channel_name(*channel), camera.name),
        "colours of a colour image are made up from neighbours: leave channel out of capture.toml for raw "
        "images, or mosaic and channel out of [camera.sensor]");
  LoadedGray gray = read_gray(file, right_size(camera), channel);
  gray.image = image_of_camera(std::move(gray.image), camera);
  return gray;
}

CameraImages load_camera_images(const CaptureSet& set, const Camera& camera, const Fringes& fringes) {
  const CaptureCamera* source = set.find(camera.name);
  if (source == nullptr) {
    std::string names;
    for (const CaptureCamera& c : set.cameras)
      names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", c.name);
    throw UserError(ExitCode::input, set.file.string(), fmt::format("has no camera \"{}\"", camera.name),
                    "it has " + names);
  }
  check_count(set, *source, expand_sequence(fringes).size());
  if (needs_white_black(fringes) && (!source->white || !source->black))
    throw UserError(ExitCode::input, set.file.string(),
                    fmt::format("camera \"{}\" needs white and black images for threshold = \"white-black\"",
                                camera.name));
  const bool radiance = has_radiance(*source);
  LoadedImages of_files = load_images(
      *source, [&](const fs::path& file) { return load_image(file, camera, radiance, set.channel); });
  CameraImages loaded{.camera = camera.name,
                      .images = std::move(of_files.images),
                      .white = std::move(of_files.white),
                      .black = std::move(of_files.black),
                      .bit_depth = camera.sensor.bit_depth,
                      .radiance = radiance,
                      .gray_code_exposure = source->gray_code_exposure};
  loaded.clip = find_clip(loaded, fringes, camera.sensor);
  return loaded;
}

void write_camera_images(const fs::path& dir, const CameraImages& images) {
  FT_CHECK(!images.radiance, "irradiance goes to write_camera_radiance");
  write_all(dir, images, "png", [&](const fs::path& file, const ImageF& image) {
    write_gray_png(file, image, images.bit_depth <= 8 ? 8 : 16);
  });
}

void write_camera_radiance(const fs::path& dir, const CameraImages& images) {
  write_all(dir, images, "exr", [](const fs::path& file, const ImageF& image) {
    write_exr(file, {{"Y", &image}});
  });
}

}  // namespace fringetwin
