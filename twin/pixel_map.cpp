// SPDX-License-Identifier: Apache-2.0
#include "twin/pixel_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "twin/base/errors.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin {
namespace {

/// Gain_dn is the gain of the mean pixel: a map off by more than this is no map of what is left around it.
constexpr double kMeanOffOne = 0.01;

/// A map that is being read: what it is called, and how it is refused.
class MapFile {
 public:
  MapFile(std::filesystem::path file, std::string key, const MappedCamera& camera)
      : file_(std::move(file)), key_(std::move(key)), camera_(camera) {}

  ImageF read() const {
    auto channels = channels_of_file();
    if (channels.size() != 1) fail(fmt::format("has {} channels, not one", channels.size()));
    ImageF& map = channels.front().second;
    if (map.width != camera_.width || map.height != camera_.height)
      fail(fmt::format("has {} x {} px, the camera {} x {}", map.width, map.height, camera_.width,
                       camera_.height));
    return std::move(map);
  }

  /// Refuses the first value that `is_right` does not take.
  template <class IsRight>
  void check_each(const ImageF& map, IsRight is_right, const std::string& hint) const {
    const auto wrong = std::ranges::find_if_not(map.data, is_right);
    if (wrong == map.data.end()) return;
    const auto at = static_cast<int>(wrong - map.data.begin());
    fail(fmt::format("has the value {} at pixel ({}, {})", *wrong, at % map.width, at / map.width), hint);
  }

  [[noreturn]] void fail(const std::string& what, const std::string& hint = "") const {
    throw UserError(ExitCode::usage, where(), what, hint);
  }

 private:
  std::string where() const {
    return fmt::format("[camera.sensor] {} = \"{}\" of camera \"{}\"", key_, plain_text(file_.string()),
                       camera_.name);
  }

  std::vector<std::pair<std::string, ImageF>> channels_of_file() const {
    try {
      return read_exr(file_);
    } catch (const UserError& e) {
      throw UserError(ExitCode::usage, where(), e.what());
    }
  }

  std::filesystem::path file_;
  std::string key_;
  const MappedCamera& camera_;
};

}  // namespace

std::shared_ptr<const ImageF> read_pixel_factors(const std::filesystem::path& file,
                                                 const MappedCamera& camera) {
  const MapFile source(file, "prnu", camera);
  ImageF map = source.read();
  source.check_each(
      map, [](float v) { return std::isfinite(v) && v > 0.0F; },
      "a factor of a pixel is a finite number above 0");
  const double mean =
      std::accumulate(map.data.begin(), map.data.end(), 0.0) / static_cast<double>(map.size());
  if (std::abs(mean - 1.0) > kMeanOffOne)
    source.fail(fmt::format("has factors of mean {:.6g}, not 1", mean),
                "gain_dn is the gain of the mean pixel: divide the factors by their mean");
  return std::make_shared<const ImageF>(std::move(map));
}

std::shared_ptr<const ImageF> read_pixel_offsets(const std::filesystem::path& file,
                                                 const MappedCamera& camera, double full_scale_dn) {
  const MapFile source(file, "dsnu", camera);
  ImageF map = source.read();
  source.check_each(
      map,
      [full_scale_dn](float v) {
        return std::isfinite(v) && std::abs(static_cast<double>(v)) <= full_scale_dn;
      },
      "an offset of a pixel is a finite number of gray values, no larger than full scale");
  return std::make_shared<const ImageF>(std::move(map));
}

}  // namespace fringetwin
