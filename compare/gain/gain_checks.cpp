// SPDX-License-Identifier: Apache-2.0
#include "compare/gain/gain_checks.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "twin/base/constants.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::compare {
namespace {

constexpr std::size_t kMostCheckedPixels = 60'000;
constexpr int kPartBlock = 32;                // side of a block of the sandwich, px
constexpr std::uint64_t kFewestOfPart = 200;  // below this a part says nothing
constexpr double kFlatPart =
    1e-9;  // a relative determinant below it: the irradiance of the part does not vary

/// PartSums over pairs of an irradiance e and a residual r of the printed line, from which their own line
/// follows.
struct PartSums {
  double n = 0, w = 0, we = 0, wee = 0, wr = 0, wer = 0;

  void add(double weight, double e, double r) {
    n += 1, w += weight, we += weight * e, wee += weight * e * e, wr += weight * r, wer += weight * e * r;
  }
  void add(const PartSums& s, double weight) {
    n += s.n, w += weight * s.w, we += weight * s.we, wee += weight * s.wee;
    wr += weight * s.wr, wer += weight * s.wer;
  }
  /// Returns the sums with e and r taken from their means: what is left is the variation within.
  PartSums about_means() const {
    PartSums s = *this;
    s.we = s.wr = 0.0;
    s.wee -= we * we / w, s.wer -= we * wr / w;
    return s;
  }
  /// Returns the sums of the one pair of the means, with the weight of all.
  PartSums of_means() const {
    PartSums s = *this;
    s.wee = we * we / w, s.wer = we * wr / w;
    return s;
  }
  Eigen::Matrix2d normal() const {
    Eigen::Matrix2d m;
    m << w, we, we, wee;
    return m;
  }
  Eigen::Vector2d right() const { return {wr, wer}; }
};

/// The line of a part, as it differs from the printed one: black level, then gain.
struct PartLine {
  Eigen::Vector2d change = Eigen::Vector2d::Constant(kNaN), sigma = Eigen::Vector2d::Constant(kNaN);
  double inflation = kNaN;
  std::uint64_t n = 0;
};

/// Fits a line to the sums of the blocks; `has_level` false: its slope only. Returns no line where the values
/// are too few, or their irradiance does not vary.
std::optional<PartLine> fit_part(const std::vector<PartSums>& blocks, bool has_level) {
  PartSums all;
  double n_blocks = 0.0;
  for (const PartSums& block : blocks) {
    all.add(block, 1.0);
    if (block.n > 0) n_blocks += 1.0;
  }
  Eigen::Matrix2d normal = all.normal();
  if (all.n < static_cast<double>(kFewestOfPart) || !(all.wee > 0.0)) return std::nullopt;
  if (has_level && !(normal.determinant() > kFlatPart * all.w * all.wee)) return std::nullopt;
  Eigen::Matrix2d inverse = Eigen::Matrix2d::Zero();
  if (has_level)
    inverse = normal.inverse();
  else
    inverse(1, 1) = 1.0 / all.wee;
  PartLine line{.change = inverse * all.right(), .n = static_cast<std::uint64_t>(all.n)};
  Eigen::Matrix2d scores = Eigen::Matrix2d::Zero();
  for (const PartSums& block : blocks) {
    const Eigen::Vector2d score = block.right() - block.normal() * line.change;
    scores += score * score.transpose();
  }
  if (n_blocks > 2.0) scores *= n_blocks / (n_blocks - 1.0);
  const Eigen::Matrix2d sandwich = inverse * scores * inverse;
  line.inflation = std::sqrt(sandwich(1, 1) / inverse(1, 1));
  line.sigma = sandwich.diagonal().cwiseMax(inverse.diagonal()).cwiseSqrt();
  if (!has_level) line.change[0] = line.sigma[0] = kNaN;
  return line;
}

/// A pixel whose values are used: the weight is one over their predicted variance.
struct PartPixel {
  std::size_t index = 0, block = 0;
  int x = 0, y = 0;
  double weight = 0.0;
  PartSums values;  ///< of weight 1
  double mean_e() const { return values.we / values.w; }
};

class PartFits {
 public:
  PartFits(const Fringes& fringes, const GrayPair& pair, const GainFit& fit, const GrayNoise& noise)
      : pair_(pair), fit_(fit), noise_(noise), range_(fit.usable) {
    const double margin_dn = std::max(2.0, 3.0 * std::sqrt(noise.variance(range_.saturation_dn)));
    range_.low_dn = std::min(range_.low_dn, margin_dn);
    range_.high_dn = std::max(range_.high_dn, range_.saturation_dn - margin_dn);
    across_ = static_cast<std::size_t>((pair.width() + kPartBlock - 1) / kPartBlock);
    n_blocks_ = across_ * static_cast<std::size_t>((pair.height() + kPartBlock - 1) / kPartBlock);
    name_groups(fringes);
  }

  GainParts run(const ImageU8& interior) {
    GainParts out;
    read(choose(interior));
    if (n_sound_ > 0) out.dropped_fraction = static_cast<double>(n_dropped_) / static_cast<double>(n_sound_);
    if (pixels_.empty()) return out;
    add(out.rows, kAllValues, sum([](const PartPixel&) { return true; }));
    if (out.rows.empty()) return out;
    std::vector<PartSums> within(n_blocks_), between(n_blocks_);
    for (const PartPixel& p : pixels_) {
      within[p.block].add(p.values.about_means(), p.weight);
      between[p.block].add(p.values.of_means(), p.weight);
    }
    add(out.rows, kWithinPixels, within, false);
    add(out.rows, kBetweenPixels, between);
    add_halves(out.rows, "left half", "right half", [](const PartPixel& p) { return p.x; });
    add_halves(out.rows, "upper half", "lower half", [](const PartPixel& p) { return p.y; });
    add_halves(out.rows, "dark half", "bright half", [](const PartPixel& p) { return p.mean_e(); });
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      std::vector<PartSums> blocks(n_blocks_);
      for (std::size_t b = 0; b < n_blocks_; ++b) blocks[b] = group_sums_[b * groups_.size() + g];
      add(out.rows, groups_[g], blocks);
    }
    return out;
  }

 private:
  /// Names the groups of single values: low and high ones, then steps and pitches, with which of these each
  /// image belongs to. What is one step or pitch only is all values.
  void name_groups(const Fringes& fringes) {
    std::vector<std::string> steps, pitches;
    const auto find_or_add = [](std::vector<std::string>& names, const std::string& name) {
      const auto at = std::ranges::find(names, name);
      if (at != names.end()) return static_cast<std::size_t>(at - names.begin());
      names.push_back(name);
      return names.size() - 1;
    };
    for (const int image : pair_.gain_images) {
      const PatternSpec& p = pair_.patterns[image];
      std::pair<std::size_t, std::size_t> of{kNoGroup, kNoGroup};
      if (p.kind == PatternSpec::Kind::phase_step) {
        const DirectionFringes& d = fringes.directions.at(p.direction);
        of.first = find_or_add(steps, fmt::format("step {}/{}", p.step + 1, fringes.steps));
        of.second =
            find_or_add(pitches, fmt::format("{} pitch {}", axis_name(d.axis), d.pitches_px.at(p.pitch)));
      }
      group_of_.push_back(of);
    }
    groups_ = {kLowValues, kHighValues};
    const std::size_t first_step = groups_.size();
    if (steps.size() > 1) groups_.insert(groups_.end(), steps.begin(), steps.end());
    const std::size_t first_pitch = groups_.size();
    if (pitches.size() > 1) groups_.insert(groups_.end(), pitches.begin(), pitches.end());
    for (auto& [step, pitch] : group_of_) {
      step = steps.size() < 2 || step == kNoGroup ? kNoGroup : first_step + step;
      pitch = pitches.size() < 2 || pitch == kNoGroup ? kNoGroup : first_pitch + pitch;
    }
  }

  /// Returns the chosen pixels of every block.
  std::vector<std::vector<PartPixel>> choose(const ImageU8& interior) const {
    std::vector<std::vector<PartPixel>> chosen(n_blocks_);
    const auto width = static_cast<std::size_t>(pair_.width());
    for (const std::size_t i : set_pixels(interior, kMostCheckedPixels)) {
      PartPixel p;
      p.index = i;
      p.x = static_cast<int>(p.index % width), p.y = static_cast<int>(p.index / width);
      p.block =
          static_cast<std::size_t>(p.y / kPartBlock) * across_ + static_cast<std::size_t>(p.x / kPartBlock);
      chosen[p.block].push_back(p);
    }
    return chosen;
  }

  /// Reads the values of the pixels, block by block in parallel; keeps the pixels with two values or more.
  void read(std::vector<std::vector<PartPixel>> chosen) {
    group_sums_.assign(n_blocks_ * groups_.size(), {});
    std::vector<std::uint64_t> sound(n_blocks_, 0), dropped(n_blocks_, 0);
#pragma omp parallel for schedule(dynamic)
    for (std::size_t b = 0; b < n_blocks_; ++b)
      for (PartPixel& p : chosen[b]) read_pixel(p, sound[b], dropped[b]);
    for (std::size_t b = 0; b < n_blocks_; ++b) {
      n_sound_ += sound[b], n_dropped_ += dropped[b];
      for (const PartPixel& p : chosen[b])
        if (p.values.n > 1.0) pixels_.push_back(p);
    }
  }

  void read_pixel(PartPixel& p, std::uint64_t& sound, std::uint64_t& dropped) {
    const double gain = fit_.row.gain_dn, black = fit_.row.black_level_dn;
    std::vector<Value> values;
    for (std::size_t k = 0; k < pair_.gain_images.size(); ++k) {
      const int image = pair_.gain_images[k];
      const double y = pair_.real_at(image, p.index), v = pair_.source_at(image, p.index);
      const double e = pair_.irradiance_at(image, p.index), predicted = gain * e + black;
      if (!is_usable(range_, y, v, predicted)) continue;
      ++sound;
      if (predicted < fit_.usable.low_dn || predicted > fit_.usable.high_dn) ++dropped;
      values.push_back({k, e, y - predicted});
      p.values.add(1.0, e, y - predicted);
    }
    if (values.size() < 2) return;
    // the noise at the predicted level: that of the real values would weigh down those that came out high
    const double level_dn = std::max(gain * p.mean_e() + black, 0.0);
    p.weight = 1.0 / std::max(noise_.variance(level_dn), kRoundingVariance);
    PartSums* const groups = group_sums_.data() + p.block * groups_.size();
    const double mean_e = p.mean_e();
    for (const Value& v : values)
      for (const std::size_t group :
           {v.e < mean_e ? kLow : kHigh, group_of_[v.image].first, group_of_[v.image].second})
        if (group != kNoGroup) groups[group].add(p.weight, v.e, v.r);
  }

  template <class Chosen>
  std::vector<PartSums> sum(Chosen chosen) const {
    std::vector<PartSums> blocks(n_blocks_);
    for (const PartPixel& p : pixels_)
      if (chosen(p)) blocks[p.block].add(p.values, p.weight);
    return blocks;
  }

  /// Adds the two halves of the pixels below and from the median of `key` on.
  template <class Key>
  void add_halves(std::vector<GainCheck>& rows, const char* below, const char* above, Key key) const {
    std::vector<double> keys;
    for (const PartPixel& p : pixels_) keys.push_back(static_cast<double>(key(p)));
    const double middle = upper_median(keys);
    add(rows, below, sum([&](const PartPixel& p) { return static_cast<double>(key(p)) < middle; }));
    add(rows, above, sum([&](const PartPixel& p) { return static_cast<double>(key(p)) >= middle; }));
  }

  /// Adds the row of a part, unless its values say nothing.
  void add(std::vector<GainCheck>& rows, const std::string& part, const std::vector<PartSums>& blocks,
           bool has_level = true) const {
    const std::optional<PartLine> line = fit_part(blocks, has_level);
    if (!line) return;
    GainCheck row{.camera = pair_.camera->name, .part = part};
    row.black_level_dn = fit_.row.black_level_dn + line->change[0];
    row.black_level_sigma_dn = line->sigma[0];
    row.gain_dn = fit_.row.gain_dn + line->change[1];
    row.gain_sigma_dn = line->sigma[1];
    row.sigma_inflation = line->inflation;
    row.n = line->n;
    if (!rows.empty()) {
      const GainCheck& all = rows.front();
      row.gain_z = (row.gain_dn - all.gain_dn) / std::hypot(row.gain_sigma_dn, all.gain_sigma_dn);
      row.black_level_z = (row.black_level_dn - all.black_level_dn) /
                          std::hypot(row.black_level_sigma_dn, all.black_level_sigma_dn);
    }
    rows.push_back(std::move(row));
  }

  static constexpr std::size_t kNoGroup = static_cast<std::size_t>(-1), kLow = 0, kHigh = 1;
  struct Value {
    std::size_t image;  ///< index into gain_images
    double e, r;
  };

  const GrayPair& pair_;
  const GainFit& fit_;
  const GrayNoise& noise_;
  UsableRange range_;
  std::size_t across_ = 0, n_blocks_ = 0;
  std::vector<std::string> groups_;                            ///< low and high values, steps, pitches
  std::vector<std::pair<std::size_t, std::size_t>> group_of_;  ///< step and pitch of each of gain_images
  std::vector<PartSums> group_sums_;  ///< block by block, all groups of a block together
  std::vector<PartPixel> pixels_;
  std::uint64_t n_sound_ = 0, n_dropped_ = 0;
};

}  // namespace

GainParts gain_checks(const Fringes& fringes, const GrayPair& pair, const GainFit& fit,
                      const GrayNoise& noise, const ImageU8& interior) {
  return PartFits(fringes, pair, fit, noise).run(interior);
}

}  // namespace fringetwin::compare
