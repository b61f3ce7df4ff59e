// SPDX-License-Identifier: Apache-2.0
#include "twin/mosaic_channel.hpp"

#include <algorithm>

#include "twin/base/errors.hpp"

namespace fringetwin {
namespace {

/// Returns which of the four filters, numbered by rows, is a mosaic's filter of a colour.
int filter_of(const std::string& mosaic, MosaicColour colour) {
  const char letter = colour == MosaicColour::red ? 'R' : colour == MosaicColour::blue ? 'B' : 'G';
  const std::size_t at = colour == MosaicColour::green2 ? mosaic.rfind(letter) : mosaic.find(letter);
  FT_CHECK(at < 4, "a mosaic without the colour");
  return static_cast<int>(at);
}

Lens scaled(const Lens& lens, double factor, const Eigen::Vector2d& principal_px,
            const Eigen::Vector2i& size_px, const std::string& where) {
  std::vector<double> intrinsics = lens.intrinsics();
  intrinsics[0] *= factor;
  intrinsics[1] *= factor;
  intrinsics[2] = principal_px.x();
  intrinsics[3] = principal_px.y();
  return {lens.model(), intrinsics, size_px, where};
}

Eigen::Vector2d principal_point_px(const Lens& lens) { return {lens.intrinsics()[2], lens.intrinsics()[3]}; }

}  // namespace

Eigen::Vector2i MosaicChannel::first_px() const {
  const int filter = filter_of(mosaic, colour);
  return {filter % 2, filter / 2};
}

Eigen::Vector2i MosaicChannel::image_px() const {
  const Eigen::Vector2i left = sensor_px - first_px();
  return {(left.x() + 1) / 2, (left.y() + 1) / 2};
}

const std::vector<std::string>& mosaic_names() {
  static const std::vector<std::string> names{"RGGB", "BGGR", "GRBG", "GBRG"};
  return names;
}

const std::vector<std::string>& mosaic_colour_names() {
  static const std::vector<std::string> names{"red", "green", "green2", "blue"};
  return names;
}

std::optional<MosaicColour> mosaic_colour(const std::string& name) {
  const auto& names = mosaic_colour_names();
  const auto at = std::ranges::find(names, name);
  if (at == names.end()) return std::nullopt;
  return static_cast<MosaicColour>(at - names.begin());
}

const std::string& name_of(MosaicColour colour) {
  return mosaic_colour_names()[static_cast<std::size_t>(colour)];
}

std::string text_of(const MosaicChannel& channel) {
  return name_of(channel.colour) + " of " + channel.mosaic;
}

Eigen::Vector2d sensor_place_px(const MosaicChannel& channel, const Eigen::Vector2d& image_place_px) {
  return 2.0 * image_place_px + channel.first_px().cast<double>();
}

Eigen::Vector2d image_place_px(const MosaicChannel& channel, const Eigen::Vector2d& sensor_place_px) {
  return 0.5 * (sensor_place_px - channel.first_px().cast<double>());
}

Lens image_lens(const Lens& sensor_lens, const MosaicChannel& channel, const std::string& where) {
  return scaled(sensor_lens, 0.5, image_place_px(channel, principal_point_px(sensor_lens)),
                channel.image_px(), where);
}

Lens sensor_lens(const Lens& image_lens, const MosaicChannel& channel) {
  return scaled(image_lens, 2.0, sensor_place_px(channel, principal_point_px(image_lens)), channel.sensor_px,
                "the lens of the whole sensor");
}

}  // namespace fringetwin
