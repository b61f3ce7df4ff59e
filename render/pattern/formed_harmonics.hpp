// SPDX-License-Identifier: Apache-2.0
// Forms the harmonics of added light from the mean and the fundamental of a pixel, where the phase runs
// smoothly through it, and bounds what that leaves out (docs/PHYSICS.md, "Harmonics from the fundamental").
// Pixels where that is too much are traced with a pair per harmonic.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "render/base/transport.hpp"
#include "render/pattern/pattern_plan.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

/// What the harmonics of a direction's pitches weigh, of the fundamental, at its finest pitch that has any:
/// sums over the orders k of size times k^2, (k^3 - k)/6, (k^4 - k^2)/24, k^6/720 and k^8/37800.
struct HarmonicWeights {
  std::size_t pitch = 0;     ///< the finest that has any
  double fundamental = 0.0;  ///< amplitude of its light, of full scale
  double k2 = 0.0, k3 = 0.0, k4 = 0.0, k6 = 0.0, k8 = 0.0;
  double in_phase = 0.0;  ///< share of it that the steps cannot tell from the fundamental, at most
  bool any() const { return k2 > 0.0; }
};

/// How the harmonics of a trace are formed. Without `own` passes they are all summed up.
struct HarmonicsPlan {
  std::vector<PassPlan> own;             ///< a pair per harmonic, no direct images: for pixels in lists
  std::vector<HarmonicWeights> weights;  ///< per direction
  bool formed() const { return !own.empty(); }
  /// Returns what an error of the contrast counts with its harmonics, of one of the fundamental alone.
  double worst() const;
};

/// Returns true where harmonics may be formed: added light alone, seen and thrown without depth of field, by
/// light that comes straight from the projector.
bool may_form_harmonics(const Twin& twin);
/// Returns a plan whose `own` is empty where the harmonics of `series` are too fine for the camera's pixels.
HarmonicsPlan plan_harmonics(const Twin& twin, const Camera& camera, const SeriesTable& series,
                             double phase_error_rad, double center_x_px, double center_y_px);
/// Returns the series without harmonics.
SeriesTable fundamentals_of(const SeriesTable& series);

/// The sums of one harmonic of some pixels.
struct FormedPair {
  float *cosine, *sine;
};
/// Forms the pairs of the orders 2, 3 ... of the pixels [first, first + n): pairs[k - 2] has room for n
/// values each. Pixels with sums of their own get these. `blur_px`: the blur that the sums hold.
void form_harmonics(const Transport& transport, std::size_t direction, std::size_t pitch, double pitch_px,
                    double blur_px, std::ptrdiff_t first, std::ptrdiff_t n,
                    std::span<const FormedPair> pairs);

/// Adds c cosine - s sine of n values to an image.
void add_formed(const FormedPair& pair, float c, float s, std::ptrdiff_t n, float* out);

/// What a pixel of the fundamental's images is to find_unformed(): within one surface; on facets of a mesh,
/// with creases; one whose sums are not looked at.
enum class PixelState : std::uint8_t { plain, facets, own };
/// Bounds up to which find_unformed() leaves a pixel alone.
struct FormedLimits {
  double irradiance = 0.0, phase_rad = 0.0;
  double fill = 1.0;  ///< side of a pixel's square
};
/// Bounds of what forming leaves out of a pixel: of an irradiance, and of the phase of the steps.
struct FormedError {
  std::uint32_t place = 0;  ///< index in the image
  double irradiance = 0.0, phase_rad = 0.0;
};
/// Sums of their squares.
struct FormedErrors {
  double irradiance_squares = 0.0, phase_squares = 0.0;
  void add(const FormedError& e) {
    irradiance_squares += e.irradiance * e.irradiance;
    phase_squares += e.phase_rad * e.phase_rad;
  }
};
/// Appends the lit pixels of a block whose bounds are above the limits, by the turns to their neighbours, and
/// returns those of the others. Pixels that are `own` are passed over. Without `states` there may be creases
/// anywhere.
FormedErrors find_unformed(const Transport& transport, const HarmonicsPlan& plan,
                           std::span<const PixelState> states, int x0, int y0, const FormedLimits& limits,
                           std::vector<FormedError>* large);

/// Keeps the harmonics of a pixel in the transport; channel(c) returns what goes there from channel c of the
/// pass.
template <class Channel>
void keep_harmonics(const PassPlan& pass, std::uint32_t place, Transport* out, Channel channel) {
  for (std::size_t i = 0; i < pass.pitches.size(); ++i) {
    const PitchSlot& slot = pass.pitches[i];
    if (slot.harmonic == 1) continue;
    auto& own = out->own_harmonics[slot.direction][slot.pitch];
    if (slot.harmonic == 2) own.places.push_back(place);
    own.sums.push_back(channel(2 + 2 * i));
    own.sums.push_back(channel(3 + 2 * i));
  }
}
/// Puts what was kept into the order of the image.
void sort_harmonics(Transport* transport);

}  // namespace fringetwin::render
