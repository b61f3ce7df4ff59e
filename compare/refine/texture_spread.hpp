// SPDX-License-Identifier: Apache-2.0
// Fits how far a pixel of the image reaches, by what a texture that changes within it does to its gray
// values: these and the twin's light go in, a standard deviation in pixels comes out (docs/metrics/causes.md,
// "Spread of a texture").
#pragma once
#include <optional>
#include <vector>

#include "compare/gray/own_light.hpp"
#include "compare/result/verdict_tables.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// Gray values of a camera over black beside the light of the twin, of the images that are chosen; both over
/// the exposure of their image and the gray values over the gain, so that a pixel shows factor * light +
/// offset. Keeps references to what it is given.
class GrayOverLight {
 public:
  GrayOverLight(const CameraImages& real, const std::vector<GrayImage>& light, const std::vector<int>& images,
                const std::vector<double>& exposures, const Refinement::Line& line);
  const std::vector<std::size_t>& images() const { return images_; }  ///< sequence indices
  const std::vector<GrayImage>& light() const { return light_; }      ///< as it was given, by sequence index
  double exposure(std::size_t image) const { return factor_of(exposures_, image); }
  bool is_usable(std::size_t image, std::size_t pixel) const {
    return static_cast<double>(real_.images[image][pixel]) < saturation_dn_;
  }
  double gray_at(std::size_t image, std::size_t pixel) const {
    return (static_cast<double>(real_.images[image][pixel]) - line_.black_level_dn) / line_.gain_dn /
           exposure(image);
  }
  double light_at(std::size_t image, std::size_t pixel) const {
    return static_cast<double>(light_[image][pixel]) / exposure(image);
  }

 private:
  const CameraImages& real_;
  const std::vector<GrayImage>& light_;
  const std::vector<double>& exposures_;
  Refinement::Line line_;
  std::vector<std::size_t> images_;
  double saturation_dn_;
};

struct TextureSpread {
  double spread_px = 0.0, sigma_px = 0.0;
};

/// Returns the spread that brings the values closest to those that the twin's light makes of this texture,
/// whose factors come from them without a spread: least squares on what the line of each pixel leaves, noise
/// of the factors' slopes taken out; standard error by the scatter of blocks of 32 px. Pixels count whose
/// light is smooth without fringes (no outline, no border of a shadow). nullopt where its square is not clear
/// of zero by 5 standard errors, fewer than 1000 pixels or 12 blocks tell it, or there is no factor.
std::optional<TextureSpread> fit_texture_spread(const OwnKinds& kinds, const GrayOverLight& values,
                                                const PixelTexture& texture);

}  // namespace fringetwin::compare
