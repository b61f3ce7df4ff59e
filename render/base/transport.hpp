// SPDX-License-Identifier: Apache-2.0
// Holds the transport of light to one camera, which no step of the patterns changes: the sums per pixel
// that one trace measures, from which all images of the sequence are formed (pattern/form_images.hpp), and
// the estimate of their error.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "render/base/phase_series.hpp"
#include "render/base/sampling.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::render {

/// The renderer's own estimate of its error, meant as an upper bound (tested on scenes of its own).
struct ErrorEstimate {
  double phase_rad = 0.0;    ///< rms at the finest pitch over lit pixels without an edge, rounding included
  double gray = 0.0;         ///< rms over all pixels that see an object, fraction of full scale
  double gray_inside = 0.0;  ///< the same without the pixels an edge crosses; with facets of a mesh as `gray`
  double mixed_share = 0.0;  ///< share of those pixels that an edge crosses
  double facets_share = 0.0;  ///< share of those pixels whose facets of a mesh are clipped exactly
  double smooth_share = 0.0;  ///< share of those pixels that one surface fills and that needed more rays
};

/// What a trace of one camera saw and did, besides the light.
struct TraceRecord {
  Image<std::int32_t> object;  ///< index of the object at the pixel centre's ray, -1 none
  Sampling sampling;           ///< what was done: a fixed rule where adaptive does not apply
  double trace_ms = 0.0;
  std::uint64_t rays = 0;                 ///< primary + shadow
  std::optional<ErrorEstimate> estimate;  ///< adaptive only
};

/// The cost of one step of the adaptive trace, for benchmarks.
struct StageCost {
  std::string name;
  std::size_t pixels = 0;
  std::uint64_t rays = 0;
  double cpu_ms = 0.0;  ///< of all threads of the process
};

/// Per-pixel transport of one camera (all images W x H, irradiance per unit pattern value).
/// w is the irradiance that a ray brings where the pattern value is 1, theta the phase of the fringe that it
/// meets. A pattern whose series has the coefficients a_k (response and blur included) and that is shifted by
/// delta gives E = ambient_hit + a_0 mean + sum_k a_k (cosine_k cos(k delta) - sine_k sin(k delta)); sines
/// b_k add sum_k b_k (cosine_k sin(k delta) + sine_k cos(k delta)).
struct Transport : TraceRecord {
  ImageF mean;     ///< mean of w over the pixel (pattern value 1 everywhere)
  ImageF ambient;  ///< light of the room: ambient irradiance x hit fraction, and a lamp's
  /// [direction][pitch]: mean of w cos(theta), w sin(theta), theta = 2 pi (x - origin)/pitch; the
  /// fundamental with the blur attenuation already in it. Empty where the steps are evaluated directly.
  std::vector<std::vector<ImageF>> cosine, sine;
  /// [direction][pitch][k - 2]: the same of harmonic k >= 2, where a fringe's light is no pure cosine.
  struct Pair {
    ImageF cosine, sine;
  };
  std::vector<std::vector<std::vector<Pair>>> harmonics;
  /// [direction][pitch]: the sums of these pixels where `harmonics` has none but `series` does: those of the
  /// others are formed from mean and fundamental (pattern/formed_harmonics.hpp).
  struct OwnHarmonics {
    std::vector<std::uint32_t> places;  ///< in the image, rising
    std::vector<float> sums;            ///< per place and order 2, 3 ...: cosine, sine
  };
  std::vector<std::vector<OwnHarmonics>> own_harmonics;
  /// [direction][pitch]: a_k, b_k of the form above before blur; empty where the steps are evaluated
  /// directly.
  SeriesTable series;
  /// What the series have more at a place of the projector's image, per term of the harmonics' field, and the
  /// value of each term at the place that lights a pixel; empty without a field.
  SeriesOfField series_of_field;
  std::vector<ImageF> field_terms;
  /// [direction][pitch][wave]: the sums of the waves of the raster, 2 pi |turns per fringe| (x -
  /// origin)/pitch; empty without.
  std::vector<std::vector<std::vector<Pair>>> waves;
  /// Images evaluated directly in the trace (mean of w * value), by sequence index; empty elsewhere.
  std::vector<ImageF> direct;
  int repeated_dispatches = 0;    ///< because the driver cut an invocation's loops short
  std::vector<StageCost> stages;  ///< adaptive only
};

}  // namespace fringetwin::render
