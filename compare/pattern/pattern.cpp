// SPDX-License-Identifier: Apache-2.0
#include "compare/pattern/pattern.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numeric>

#include "compare/pattern/pattern_bins.hpp"

namespace fringetwin::compare {
namespace {

constexpr int kMostHarmonic = 7;  ///< as the group `harmonics`
/// What is named takes away a tenth of the excess, which is a third of the size of what is left, and five
/// standard deviations of what chance does. The gain of noise in a bin of four parts alike is w - 7/9 v +
/// 4/3, w and v being chi2 of 1 and 3 degrees of freedom: its variance is 2 + 6 (7/9)^2.
constexpr double kNamedShare = 0.1, kNamedSigmas = 5.0, kChanceVariance = 2.0 + 6.0 * 49.0 / 81.0;

/// What a coordinate is called, and where its pattern says to look, in the order of pattern_bins.hpp.
struct CoordinateWords {
  const char *name, *unit, *words, *look_at;
};
constexpr CoordinateWords kCoordinates[] = {
    {"gray_level", "DN", "the gray level", "response of the camera or the projector"},
    {"phase", "rad", "the phase of the fringes", "waveform of the fringes"},
    {"image", "", "the image number", "light that changes from image to image"},
    {"radius", "px", "the radius from the middle of the image", "lens or vignetting of the camera"},
    {"place", "px", "the place in the image", "surfaces or light there, see the map"},
    {"phase_by_place", "rad", "the phase of the fringes, from place to place another way",
     "waveform of the fringes that differs over the image (harmonics_field)"},
    {"phase_by_image", "rad", "the phase of the fringes, from image to image another way",
     "waveform of the fringes that differs from image to image, as where an exposure does not hold whole "
     "frames of the projector (image_harmonics)"}};
constexpr const char* kContrastOrShift = "contrast or shift of the fringes";

/// The values of all cameras, sorted by one coordinate; each camera has bins of its own.
struct SortedValues {
  PatternRow row;
  std::vector<int> bin;                  ///< of each value
  std::vector<std::uint8_t> part;        ///< that each value is predicted in from the others
  std::vector<std::uint8_t> other_part;  ///< of another division, where both must tell the same; else empty
  std::size_t n_bins = 0;
};

/// What the means of bins take away.
struct Taken {
  double gain = 0.0;                   ///< of chi2, where the means come from the other parts; 0 for noise
  std::vector<double> mean, n, gains;  ///< of each bin: over all parts, and its part of the gain
};

Taken take_means(const std::vector<double>& left, const SortedValues& by,
                 const std::vector<std::uint8_t>& part) {
  struct Sum {
    double sum = 0.0, n = 0.0;
  };
  std::vector<std::array<Sum, kPatternParts>> sums(by.n_bins);
  for (std::size_t i = 0; i < left.size(); ++i) {
    if (by.bin[i] < 0) continue;
    Sum& s = sums[static_cast<std::size_t>(by.bin[i])][part[i]];
    s.sum += left[i];
    s.n += 1.0;
  }
  Taken out;
  for (const auto& parts : sums) {
    Sum all;
    double gain = 0.0;
    for (const Sum& s : parts) all.sum += s.sum, all.n += s.n;
    for (const Sum& s : parts) {
      const double others = all.n - s.n;
      if (others < s.n || others == 0.0) continue;
      const double mean = (all.sum - s.sum) / others;
      // sum of z^2 - (z - mean)^2, and what the noise of the mean costs
      gain += mean * (2.0 * s.sum - mean * s.n) + s.n / others;
    }
    out.gain += gain;
    out.gains.push_back(gain);
    out.mean.push_back(all.n > 0.0 ? all.sum / all.n : kNaN);
    out.n.push_back(all.n);
  }
  return out;
}

Taken take_means(const std::vector<double>& left, const SortedValues& by) {
  Taken out = take_means(left, by, by.part);
  if (by.other_part.empty()) return out;
  // of each image the lesser: the fringes of one may lie along x, and of another along y
  const std::vector<double> other = take_means(left, by, by.other_part).gains;
  out.gain = 0.0;
  for (std::size_t first = 0; first < by.n_bins; first += kPhaseBins) {
    const auto of_image = [first](const std::vector<double>& gains) {
      const auto begin = gains.begin() + static_cast<std::ptrdiff_t>(first);
      return std::accumulate(begin, begin + kPhaseBins, 0.0);
    };
    out.gain += std::min(of_image(out.gains), of_image(other));
  }
  return out;
}

/// `bin` of each value; -1: of none.
std::vector<double> without_means(std::vector<double> left, const std::vector<int>& bin,
                                  const std::vector<double>& mean) {
  for (std::size_t i = 0; i < left.size(); ++i)
    if (bin[i] >= 0) left[i] -= mean[static_cast<std::size_t>(bin[i])];
  return left;
}

std::vector<double> without_own_means(std::vector<double> left, const std::vector<int>& bin,
                                      std::size_t n_bins) {
  std::vector<double> mean(n_bins), n(n_bins);
  for (std::size_t i = 0; i < left.size(); ++i)
    if (bin[i] >= 0) mean[static_cast<std::size_t>(bin[i])] += left[i], ++n[static_cast<std::size_t>(bin[i])];
  for (std::size_t b = 0; b < n_bins; ++b) mean[b] /= n[b];
  return without_means(std::move(left), bin, mean);
}

/// Returns the harmonic that holds half or more of the squares of means over the phase, of which every
/// `n_bins` are a period, 0 where none does.
std::uint64_t main_harmonic(const std::vector<PatternProfile>& profiles, std::size_t n_bins) {
  for (int h = 1; h <= kMostHarmonic; ++h) {
    double in_it = 0.0, in_all = 0.0;
    for (const PatternProfile& p : profiles)
      for (std::size_t first = 0; first < p.at.size(); first += n_bins) {
        std::complex<double> sum = 0.0;
        double n = 0.0;
        for (std::size_t b = first; b < first + n_bins; ++b) {
          if (!(p.n[b] > 0.0)) continue;
          sum += p.n[b] * p.mean[b] * std::polar(1.0, h * p.at[b]);
          in_all += p.n[b] * p.mean[b] * p.mean[b];
          n += p.n[b];
        }
        if (n > 0.0) in_it += 2.0 * std::norm(sum) / n;
      }
    if (in_it >= 0.5 * in_all && in_all > 0.0) return static_cast<std::uint64_t>(h);
  }
  return 0;
}

class PatternSearch {
 public:
  PatternSearch(const std::vector<LeftOver>& cameras, double excess) : excess_(excess) {
    for (const CoordinateWords& words : kCoordinates) {
      SortedValues& by = sorted_.emplace_back();
      by.row.coordinate = words.name;
      by.row.unit = words.unit;
    }
    for (const LeftOver& camera : cameras)
      if (!camera.values.empty()) add(camera);
  }

  std::vector<PatternRow> run() {
    if (left_.empty()) return {};
    for (SortedValues& by : sorted_) {
      const Taken taken = take_means(left_, by);
      by.row.alone = share(taken.gain);
      fill_profile(by.row, taken);
    }
    sorted_[kPhase].row.harmonic = main_harmonic(sorted_[kPhase].row.profile, kPatternBins);
    int order = 1;
    while (take_best(order)) ++order;
    while (take_phase_by_another(order)) ++order;
    std::vector<PatternRow> rows;
    for (SortedValues& by : sorted_) rows.push_back(std::move(by.row));
    return rows;
  }

 private:
  void add(const LeftOver& camera) {
    double mean = 0.0;  // a constant is no pattern: the black level takes it
    for (const LeftValue& v : camera.values)
      mean += static_cast<double>(v.sigmas) / static_cast<double>(camera.values.size());
    for (const LeftValue& v : camera.values) left_.push_back(static_cast<double>(v.sigmas) - mean);
    for (const int pixel : numbers_of_pixels(camera.values)) {
      pixel_.push_back(static_cast<int>(n_pixels_) + pixel);
      camera_.push_back(static_cast<int>(n_cameras_));
    }
    n_pixels_ += camera.values.size();  // at most
    ++n_cameras_;
    const std::vector<std::uint8_t> by_image = quarters_of_image(camera.values),
                                    by_sequence = quarters_of_sequence(camera.values),
                                    by_x = strips_of_image(camera.values, &LeftValue::x_px),
                                    by_y = strips_of_image(camera.values, &LeftValue::y_px);
    for (std::size_t c = 0; c < sorted_.size(); ++c) {
      SortedValues& by = sorted_[c];
      Bins bins = bins_of(c, camera);
      for (const int bin : bins.of) by.bin.push_back(bin < 0 ? -1 : bin + static_cast<int>(by.n_bins));
      // Along a fringe the phase is the same, and what finer bins would hold is alike: strips across it
      // differ.
      const auto& part = c == kPlace || c == kPhaseByPlace ? by_sequence
                         : c == kPhaseByImage              ? by_x
                                                           : by_image;
      by.part.insert(by.part.end(), part.begin(), part.end());
      if (c == kPhaseByImage) by.other_part.insert(by.other_part.end(), by_y.begin(), by_y.end());
      by.n_bins += bins.at.size();
      by.row.profile.push_back({camera.camera, std::move(bins.at), std::move(bins.at_y), {}, {}});
    }
  }
  static void fill_profile(PatternRow& row, const Taken& taken) {
    auto mean = taken.mean.begin(), n = taken.n.begin();
    for (PatternProfile& p : row.profile) {
      const auto size = static_cast<std::ptrdiff_t>(p.at.size());
      p.mean.assign(mean, mean + size), p.n.assign(n, n + size);
      mean += size, n += size;
    }
  }
  /// Returns what the means must take away to be named.
  double least(std::size_t c) const {
    return std::max(kNamedShare * excess_,
                    kNamedSigmas * std::sqrt(kChanceVariance * static_cast<double>(sorted_[c].n_bins)));
  }
  double share(double gain) const { return std::clamp(gain / excess_, 0.0, 1.0); }

  /// Returns what is named and leaves nothing worth naming of what the first one takes: these two cannot be
  /// told apart.
  std::vector<std::size_t> alike(std::size_t first, const std::vector<Taken>& taken) const {
    std::vector<std::size_t> all;
    for (std::size_t c = 0; c < kPhaseByPlace; ++c)
      if (c != first && sorted_[c].row.order == 0 && taken[c].gain >= least(c) &&
          take_means(without_means(left_, sorted_[c].bin, taken[c].mean), sorted_[first]).gain < least(first))
        all.push_back(c);
    return all;
  }

  /// Names the coordinate that takes away most of what is left, and takes its means off; returns whether
  /// there is one. A map holds what follows one number, too: the number is named before it.
  bool take_best(int order) {
    std::vector<Taken> taken;
    for (std::size_t c = 0; c < kPhaseByPlace; ++c) taken.push_back(take_means(left_, sorted_[c]));
    const auto gain_of = [&](std::size_t c) { return sorted_[c].row.order == 0 ? taken[c].gain : 0.0; };
    std::size_t best = 0;
    for (std::size_t c = 1; c < kPhaseByPlace; ++c)
      if (gain_of(c) > gain_of(best)) best = c;
    if (!(gain_of(best) >= least(best))) return false;
    std::vector<std::size_t> together = alike(best, taken);
    if (best == kPlace && !together.empty()) {
      best = *std::ranges::max_element(together, {}, gain_of);
      together = alike(best, taken);
    }
    std::erase(together, kPlace);
    together.push_back(best);
    for (const std::size_t c : together) {
      sorted_[c].row.order = order;
      sorted_[c].row.in_order = share(taken[c].gain);
    }
    left_ = without_means(std::move(left_), sorted_[best].bin, taken[best].mean);
    return true;
  }

  /// Returns what is left without what follows the phase alone, or the place or image alone, however little:
  /// a bin of `by` holds it, too. Of images also without the mean of each pixel: what is alike in all of them
  /// differs along the fringes.
  std::vector<double> without_parts(std::size_t c) const {
    const SortedValues& by = sorted_[c];
    std::vector<double> left = c == kPhaseByImage ? without_own_means(left_, pixel_, n_pixels_) : left_;
    std::vector<int> group, phase;
    for (std::size_t i = 0; i < left_.size(); ++i) {
      group.push_back(by.bin[i] < 0 ? -1 : by.bin[i] / kPhaseBins);
      phase.push_back(by.bin[i] < 0 ? -1 : camera_[i] * kPhaseBins + by.bin[i] % kPhaseBins);
    }
    left = without_own_means(std::move(left), group, by.n_bins / kPhaseBins);
    return without_own_means(std::move(left), phase, n_cameras_ * kPhaseBins);
  }

  /// The same of what holds the phase and the place or the image, too, and therefore comes after these.
  bool take_phase_by_another(int order) {
    std::size_t best = 0;
    Taken most;
    for (const std::size_t c : {kPhaseByPlace, kPhaseByImage})
      if (sorted_[c].row.order == 0)
        if (Taken taken = take_means(without_parts(c), sorted_[c]);
            taken.gain >= std::max(least(c), most.gain))
          best = c, most = std::move(taken);
    if (best == 0) return false;
    SortedValues& by = sorted_[best];
    by.row.order = order;
    by.row.in_order = share(most.gain);
    fill_profile(by.row, most);  // without what the others have taken
    by.row.harmonic = main_harmonic(by.row.profile, kPhaseBins);
    left_ = without_means(std::move(left_), by.bin, most.mean);
    return true;
  }

  double excess_;
  std::vector<SortedValues> sorted_;
  std::vector<double> left_;         ///< of each value, without the means that were taken off
  std::vector<int> pixel_, camera_;  ///< of each value, numbered
  std::size_t n_pixels_ = 0, n_cameras_ = 0;
};

std::string ordinal(std::uint64_t n) {
  return fmt::format("{}{}", n, n == 1 ? "st" : n == 2 ? "nd" : n == 3 ? "rd" : "th");
}

/// Returns what is named of one order: "the gray level (81 % of it: response of the camera or the
/// projector)".
std::string named_in_words(const std::vector<PatternRow>& rows, int order) {
  std::string what, look_at;
  double share = 0.0;
  int n = 0;
  for (std::size_t c = 0; c < rows.size(); ++c) {
    const PatternRow& row = rows[c];
    if (row.order != order) continue;
    what += (n > 0 ? " or " : "") + std::string(kCoordinates[c].words);
    if (row.harmonic > 0) what += fmt::format(" ({} harmonic)", ordinal(row.harmonic));
    look_at +=
        (n > 0 ? "; " : "") + std::string(row.harmonic == 1 ? kContrastOrShift : kCoordinates[c].look_at);
    share = std::max(share, row.in_order);
    ++n;
  }
  if (n == 0) return "";
  return fmt::format("{}{} ({:.0f} % of it: {})", what, n > 1 ? ", which cannot be told apart here" : "",
                     100.0 * share, look_at);
}

}  // namespace

std::vector<PatternRow> find_pattern(const std::vector<LeftOver>& cameras, double excess) {
  if (!(excess > 0.0)) return {};
  return PatternSearch(cameras, excess).run();
}

std::string pattern_sentence(const std::vector<PatternRow>& rows) {
  if (rows.empty()) return "";
  std::string named;
  for (int order = 1;; ++order) {
    const std::string next = named_in_words(rows, order);
    if (next.empty()) break;
    named += (order > 1 ? ", then " : "") + next;
  }
  if (named.empty())
    return "what is left follows none of gray level, phase of the fringes (nor by place or image), image "
           "number, radius and place: no pattern found";
  const bool is_no_place = rows[kPlace].alone < kNamedShare && rows[kPhaseByPlace].order == 0;
  return "what is left follows " + named + (is_no_place ? ", not the place" : "");
}

}  // namespace fringetwin::compare
