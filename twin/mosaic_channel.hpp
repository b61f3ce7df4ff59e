// SPDX-License-Identifier: Apache-2.0
// One colour of a colour sensor as an image of its own: every pixel under filters of that colour, none made
// up from its neighbours. docs/formats/twin.md, "One colour of a colour sensor".
#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "twin/image/image.hpp"
#include "twin/lens/lens.hpp"

namespace fringetwin {

/// The filters of a Bayer mosaic: it has two greens, the first as its rows are read, and the second.
enum class MosaicColour { red, green, green2, blue };

/// The pixels of a colour sensor under one of the four filters that its mosaic repeats every 2 x 2 pixels.
struct MosaicChannel {
  /// The four filters at the sensor's top-left corner, the upper two from left to right, then the lower two:
  /// "RGGB", "BGGR", "GRBG" or "GBRG".
  std::string mosaic = "RGGB";
  MosaicColour colour = MosaicColour::green;
  Eigen::Vector2i sensor_px = {0, 0};  ///< width and height of the whole sensor

  /// Returns the sensor's column and row of the image's first pixel; the next ones are 2 further.
  Eigen::Vector2i first_px() const;
  /// Returns the image's width and height.
  Eigen::Vector2i image_px() const;
  bool operator==(const MosaicChannel&) const = default;
};

/// The mosaics that there are, and the colours, as files name them.
const std::vector<std::string>& mosaic_names();
const std::vector<std::string>& mosaic_colour_names();
/// Returns the colour of that name; nullopt of another word.
std::optional<MosaicColour> mosaic_colour(const std::string& name);
const std::string& name_of(MosaicColour colour);
/// Returns "green of RGGB", for people and for records.
std::string text_of(const MosaicChannel& channel);

/// Returns the lens of the channel's image: that of the sensor with pixels twice as large, whose centres lie
/// where the channel's pixels do. f' = f / 2, c' = (c - first) / 2; distortion is of directions and stays.
Lens image_lens(const Lens& sensor_lens, const MosaicChannel& channel, const std::string& where);
/// Returns the lens of the whole sensor, the inverse of image_lens().
Lens sensor_lens(const Lens& image_lens, const MosaicChannel& channel);

/// Returns the sensor's place of a place of the channel's image, and back.
Eigen::Vector2d sensor_place_px(const MosaicChannel& channel, const Eigen::Vector2d& image_place_px);
Eigen::Vector2d image_place_px(const MosaicChannel& channel, const Eigen::Vector2d& sensor_place_px);

/// Returns the channel's pixels of an image of the whole sensor.
template <class T>
Image<T> channel_image(const Image<T>& sensor, const MosaicChannel& channel) {
  const Eigen::Vector2i first = channel.first_px(), size = channel.image_px();
  Image<T> image(size.x(), size.y());
  for (int y = 0; y < size.y(); ++y)
    for (int x = 0; x < size.x(); ++x) image(x, y) = sensor(first.x() + 2 * x, first.y() + 2 * y);
  return image;
}

}  // namespace fringetwin
