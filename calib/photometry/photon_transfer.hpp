// SPDX-License-Identifier: Apache-2.0
// Estimates a sensor's gain and read noise by photon transfer: samples of noise at known gray levels go in, a
// line is fitted to their variance over the level, and its slope and height come out as gain and read noise.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "measure/decode/phase_noise.hpp"
#include "twin/base/constants.hpp"
#include "twin/fringes.hpp"
#include "twin/image/gray_image.hpp"

namespace fringetwin::calib {

/// A number and its standard error; NaN where unknown.
struct Estimate {
  double value = kNaN;
  double sigma = kNaN;
};

/// Holds a value of mean 0 whose variance is that of one gray value of this level, rounding included.
struct NoiseSample {
  float level_dn = 0.0f;
  float noise_dn = 0.0f;
  float roughness_dn = 0.0f;  ///< how much the scene's texture varies there, on noise_dn's scale; 0 = unknown
  std::uint16_t block = 0;    ///< number of the block, of 8 x 8 over the image: nearby errors are correlated
  std::uint16_t x = 0, y = 0;  ///< the pixel
};
inline constexpr int kBlocksPerSide = 8;
inline constexpr int kBlocks = kBlocksPerSide * kBlocksPerSide;
/// Returns the number of the block that holds pixel (x, y).
std::uint16_t block_of(int x, int y, int width, int height);

/// Appends samples from repeated images of one still scene: contrasts over the repeats, after a gain and an
/// offset per image (lamp flicker) have been fitted away. Pixels at 0 or at `saturation_dn` in any repeat are
/// left out. It appends at most about `max_samples`. Throws UserError(input) when sizes differ. Returns the
/// rms of the fitted gains about 1.
double add_repeat_noise(const std::vector<const GrayImage*>& repeats, double saturation_dn,
                        std::size_t max_samples, std::vector<NoiseSample>& samples);

/// Appends samples from the redundancy of one set of N phase steps, N > 3: the residuals of the fit of mean,
/// cosine and sine, as second differences along the stripes, where the projector's harmonics are smooth, less
/// what is left of them where the stripes lean. A contrast c of the steps has the variance sum c_k^2 v_k,
/// hence, for a variance that is linear in the level, that of the level sum c_k^2 I_k of the steps I: for N =
/// 4 the mean. roughness_dn is the largest second difference of the fitted mean, cosine and sine, which for
/// white noise is independent of noise_dn, or larger where what is left of the harmonics is.
void add_step_noise(const std::vector<const GrayImage*>& steps, const measure::StepSolver& solver, Axis axis,
                    double saturation_dn, std::size_t max_samples, std::vector<NoiseSample>& samples);

/// Appends samples from the means over the steps of each pitch, [pitch][step]; three steps are enough. A mean
/// holds no fringe. With two pitches or more, orthonormal contrasts between their means: neither texture nor
/// shading is in those; with one pitch the mean itself, where texture is left out by its roughness alone.
/// They are second differences along the stripes, so that a change of the light from pitch to pitch drops
/// out, scaled to the noise of one gray value at the mean level. `among`: pixels that are not 0 there; null:
/// all.
void add_mean_noise(const std::vector<std::vector<const GrayImage*>>& pitches,
                    const measure::StepSolver& solver, Axis axis, double saturation_dn,
                    std::size_t max_samples, std::vector<NoiseSample>& samples,
                    const ImageU8* among = nullptr);

/// Holds one point of the photon transfer curve; line_dn2 is the variance of the fitted line there.
struct TransferBin {
  double level_dn = 0.0, variance_dn2 = 0.0, sigma_dn2 = 0.0, line_dn2 = 0.0;
  std::size_t n = 0;
};

/// Holds the fitted line, variance = offset + dn_per_electron * level (the offset holds 1/12 DN^2 of
/// rounding), and what follows from it.
struct PhotonTransfer {
  Estimate dn_per_electron, electrons_per_dn;
  Estimate offset_dn2;         ///< at level 0
  Estimate read_variance_dn2;  ///< at the black level, without rounding; may be negative
  Estimate read_noise_dn;      ///< root of that variance; 0, with sigma as upper limit, where it is negative
  Estimate read_noise_electrons;
  /// Change of the slope over the range of levels, relative to the slope: 0 for a linear sensor.
  Estimate slope_change;
  double residual_rms = 0.0, residual_worst = 0.0;  ///< of the bins about the line, relative to the line
  double chi2_per_dof = 0.0;
  double black_level_dn = 0.0;
  double low_dn = 0.0, high_dn = 0.0;  ///< range of levels
  std::size_t n = 0;
  std::vector<TransferBin> bins;
};

struct TransferOptions {
  double black_level_dn = 0.0;
  double rounding_dn2 = kRoundingVariance;
  /// How many samples carry as much information as one independent sample: second differences overlap.
  double samples_per_independent = 1.0;
};

/// Sorts the samples into bins of equal width in level, takes the variance of each bin and fits a weighted
/// line through them. In each bin, samples beyond 3.5 of its sigmas are cut off, for which the variance is
/// corrected, and samples whose roughness is above 4 sigmas are left out. Standard errors are the larger of
/// the fit's own and those of a jackknife over image blocks. Throws UserError(input) when there are too few
/// samples or levels for a line (`where` names the camera).
PhotonTransfer photon_transfer(const std::vector<NoiseSample>& samples, const TransferOptions& options,
                               const std::string& where);

using measure::kCutSigmas, measure::kKeptVariance;

/// Returns the variance of samples of one level, cut as in a bin, with the standard error that as many
/// independent normal values would have; NaN without samples.
Estimate noise_variance(const std::vector<NoiseSample>& samples);

/// Holds the gray level at which the sensor saturates.
struct Saturation {
  double level_dn = 0.0;  ///< the largest value seen, or of the range when that is not reached
  bool reached = false;   ///< values pile up there
  double fraction = 0.0;  ///< of all values at that level
};
/// Finds the saturation level from the histogram of images: values pile up at the largest one when it holds 5
/// times as many as the mean of the 8 levels below and at least 20.
Saturation find_saturation(const std::vector<const GrayImage*>& images, int bit_depth);

}  // namespace fringetwin::calib
