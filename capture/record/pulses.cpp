// SPDX-License-Identifier: Apache-2.0
#include "capture/record/pulses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

namespace fringetwin::capture {
namespace {

using FaultKind = PulseFault::Kind;

constexpr double kOffInterval = 0.25;     ///< of the interval: jitter of pulses and clocks is far below
constexpr double kClockRate = 1e-3;       ///< crystals differ by 1e-4 at most
constexpr double kClearlyBetter = 3.0;    ///< one alignment of two trains than another
constexpr double kClockNoiseNs = 1000.0;  ///< below it alignments do not differ
constexpr std::size_t kIntervalsTried = 31;
constexpr std::size_t kFaultsTold = 3;
constexpr std::int64_t kMostMissingNamed = 100;
constexpr std::int64_t kLongestGap = 1'000'000;  ///< in pulses
constexpr const char* kDoubled = "doubled";
constexpr const char* kIrregular = "irregular";

/// Where the frames of a train lie among the pulses, at an interval.
struct Layout {
  std::vector<std::int64_t> slots;  ///< by frame, from 0; of a doubled one that of the pulse it doubles
  std::vector<std::string> faults;  ///< by frame
  std::vector<double> steps_ns;     ///< between neighbouring pulses
  std::int64_t n_slots = 0;         ///< from the first pulse that came to the last
  std::set<std::int64_t> taken;     ///< of them, those with a frame of their own
  std::int64_t first = 0;           ///< pulse of the sequence that slot 0 is
  bool placed = false;              ///< `first` is known
  int n_doubled = 0, n_irregular = 0;

  std::int64_t n_taken() const { return static_cast<std::int64_t>(taken.size()); }
  std::int64_t cost(int expected) const {
    return n_doubled + n_irregular + (n_slots - n_taken()) + std::abs(expected - n_slots);
  }
};

/// Goes along a train frame by frame, each held against the last pulse that is sure.
class LayoutMaker {
 public:
  LayoutMaker(const PulseTrain& train, double interval_ns)
      : frames_(train.frames), interval_ns_(interval_ns) {
    layout_.slots.resize(frames_.size());
    layout_.faults.resize(frames_.size());
    for (std::size_t i = 0; i < frames_.size(); ++i) place(i);
    for (const std::size_t damaged : waiting_) layout_.slots[damaged] = ++slot_;
    layout_.n_slots = slot_ + 1;
    for (std::size_t i = 0; i < frames_.size(); ++i)
      if (layout_.faults[i] != kDoubled) layout_.taken.insert(layout_.slots[i]);
    layout_.n_doubled = static_cast<int>(std::ranges::count(layout_.faults, kDoubled));
    layout_.n_irregular = static_cast<int>(std::ranges::count(layout_.faults, kIrregular));
  }

  Layout take() { return std::move(layout_); }

 private:
  double intervals(std::size_t from, std::size_t to) const {
    return static_cast<double>(frames_[to].camera_ns - frames_[from].camera_ns) / interval_ns_;
  }
  /// Returns how far two frames are from a whole number of intervals apart; a double's distance from its
  /// pulse fits nothing.
  static double misfit(double n) { return n < 0.5 ? 1.0 : std::abs(n - std::round(n)); }

  std::optional<std::size_t> next_whole(std::size_t i) const {
    for (++i; i < frames_.size(); ++i)
      if (frames_[i].damage.empty()) return i;
    return std::nullopt;
  }

  void place(std::size_t i) {
    if (!frames_[i].damage.empty()) {
      layout_.faults[i] = frames_[i].damage;
      waiting_.push_back(i);
    } else if (!sure_) {
      for (const std::size_t damaged : waiting_) layout_.slots[damaged] = ++slot_;
      waiting_.clear();
      be_pulse(i, 1);
    } else if (frames_[i].block_id == frames_[*sure_].block_id ||
               frames_[i].camera_ns <= frames_[*sure_].camera_ns) {
      be_double(i);
    } else {
      place_by_time(i);
    }
  }

  void place_by_time(std::size_t i) {
    const double n = intervals(*sure_, i);
    if (misfit(n) <= kOffInterval) return be_pulse(i, std::llround(std::min(n, 1.0 * kLongestGap)));
    // The frame behind it says which of the two is a pulse of the regular ones.
    const std::optional<std::size_t> next = next_whole(i);
    const double by_sure = next ? misfit(intervals(*sure_, *next)) : 1.0;
    const double by_this = next ? misfit(intervals(i, *next)) : 1.0;
    if (by_sure <= kOffInterval && by_sure <= by_this) return be_double(i);
    if (n >= 0.5) {
      layout_.faults[i] = kIrregular;
      be_pulse(i, std::max<std::int64_t>(1, static_cast<std::int64_t>(std::min(n, 1.0 * kLongestGap))));
    } else if (by_this <= kOffInterval) {  // the sure one was not
      layout_.faults[*sure_] = kDoubled;
      layout_.slots[i] = slot_;
      sure_ = i;
    } else {
      be_double(i);
    }
  }

  /// Damaged frames since the last pulse take the places between.
  void be_pulse(std::size_t i, std::int64_t steps) {
    for (std::size_t d = 0; d < waiting_.size(); ++d)
      layout_.slots[waiting_[d]] = slot_ + std::min(static_cast<std::int64_t>(d) + 1, steps);
    waiting_.clear();
    if (sure_ && steps == 1 && layout_.faults[i].empty())
      layout_.steps_ns.push_back(static_cast<double>(frames_[i].camera_ns - frames_[*sure_].camera_ns));
    slot_ += steps;
    layout_.slots[i] = slot_;
    sure_ = i;
  }
  void be_double(std::size_t i) {
    layout_.slots[i] = slot_;
    layout_.faults[i] = kDoubled;
  }

  const std::vector<PulseFrame>& frames_;
  double interval_ns_;
  Layout layout_;
  std::int64_t slot_ = -1;
  std::optional<std::size_t> sure_;   ///< the last pulse
  std::vector<std::size_t> waiting_;  ///< damaged frames behind it
};

std::vector<Layout> lay_out(const std::vector<PulseTrain>& trains, double interval_ns) {
  std::vector<Layout> layouts;
  for (const PulseTrain& train : trains) layouts.push_back(LayoutMaker(train, interval_ns).take());
  return layouts;
}

/// Intervals between frames of all cameras, sorted; at most kIntervalsTried, evenly chosen.
std::vector<double> tried_intervals(const std::vector<PulseTrain>& trains) {
  std::vector<double> all;
  for (const PulseTrain& train : trains) {
    std::optional<std::size_t> before;
    for (std::size_t i = 0; i < train.frames.size(); ++i) {
      if (!train.frames[i].damage.empty()) continue;
      const TimeNs step_ns = before ? train.frames[i].camera_ns - train.frames[*before].camera_ns : 0;
      if (step_ns > 0) all.push_back(static_cast<double>(step_ns) / static_cast<double>(i - *before));
      before = i;
    }
  }
  std::ranges::sort(all);
  if (all.size() <= kIntervalsTried) return all;
  std::vector<double> chosen;
  for (std::size_t k = 0; k < kIntervalsTried; ++k)
    chosen.push_back(all[k * (all.size() - 1) / (kIntervalsTried - 1)]);
  return chosen;
}

/// Returns the interval that leaves the fewest faults, found from the frames themselves; 1 ns where no two
/// frames tell.
double find_interval_ns(const std::vector<PulseTrain>& trains, int expected) {
  double best_ns = 1.0;
  std::optional<std::int64_t> least;
  for (const double interval_ns : tried_intervals(trains)) {
    std::int64_t cost = 0;
    std::vector<double> steps_ns;
    for (const Layout& layout : lay_out(trains, interval_ns)) {
      cost += layout.cost(expected);
      steps_ns.insert(steps_ns.end(), layout.steps_ns.begin(), layout.steps_ns.end());
    }
    if (least && cost >= *least) continue;
    least = cost;
    best_ns = interval_ns;
    if (steps_ns.empty()) continue;
    const auto middle = steps_ns.begin() + static_cast<std::ptrdiff_t>(steps_ns.size() / 2);
    std::ranges::nth_element(steps_ns, middle);
    best_ns = *middle;  // one interval alone has the jitter of two pulses
  }
  return best_ns;
}

/// Times of two cameras' frames of the same pulses.
struct ClockFit {
  double rate = 0.0;            ///< of the other clock against the first, less 1
  double rms_ns = 0.0;          ///< of what is left
  std::vector<double> left_ns;  ///< by slot of the first camera; NaN where one has no frame
};

std::vector<std::optional<double>> times_by_pulse(const PulseTrain& train, const Layout& layout,
                                                  std::int64_t first, int expected,
                                                  std::optional<TimeNs> origin) {
  std::vector<std::optional<double>> times(static_cast<std::size_t>(expected));
  // doubles do not hold the nanoseconds of a clock that counts from 1970
  for (std::size_t i = 0; i < train.frames.size(); ++i) {
    if (!layout.faults[i].empty()) continue;
    if (!origin) origin = train.frames[i].camera_ns;
    const std::int64_t pulse = layout.slots[i] + first;
    if (pulse >= 0 && pulse < expected)
      times[static_cast<std::size_t>(pulse)] = static_cast<double>(train.frames[i].camera_ns - *origin);
  }
  return times;
}

/// Fits a line to the other camera's times over the first one's; of a shared clock, takes their differences.
ClockFit fit_clocks(const std::vector<std::optional<double>>& first,
                    const std::vector<std::optional<double>>& other, bool is_shared) {
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  for (std::size_t k = 0; k < first.size(); ++k)
    if (first[k] && other[k]) n += 1.0, x += *first[k], y += *other[k] - *first[k];
  ClockFit fit;
  if (n == 0.0) return fit;
  x /= n, y /= n;
  for (std::size_t k = 0; k < first.size(); ++k) {
    if (!first[k] || !other[k]) continue;
    xx += (*first[k] - x) * (*first[k] - x);
    xy += (*first[k] - x) * (*other[k] - *first[k] - y);
  }
  if (xx > 0.0) fit.rate = xy / xx;
  if (is_shared) y = fit.rate = 0.0;
  double sum = 0.0;
  for (std::size_t k = 0; k < first.size(); ++k) {
    const bool both = first[k] && other[k];
    fit.left_ns.push_back(both ? *other[k] - *first[k] - y - fit.rate * (*first[k] - x) : NAN);
    if (both) sum += fit.left_ns.back() * fit.left_ns.back();
  }
  fit.rms_ns = std::sqrt(sum / n);
  return fit;
}

/// Returns where times are counted from that are compared between cameras: a shared clock's, or each its own.
std::optional<TimeNs> shared_origin(const PulseTrain& a, const PulseTrain& b) {
  if (!a.has_shared_clock || !b.has_shared_clock || a.frames.empty()) return std::nullopt;
  return a.frames.front().camera_ns;
}

/// Finds which pulses a train begins and ends with from another that has all: no two intervals are quite
/// equal, and both cameras saw the same. Leaves it open where they are.
void place_by_neighbour(const PulseTrain& whole, const Layout& whole_layout, const PulseTrain& train,
                        int expected, Layout* layout) {
  const std::optional<TimeNs> origin = shared_origin(whole, train);
  const auto reference = times_by_pulse(whole, whole_layout, 0, expected, origin);
  double best = INFINITY, second = INFINITY;
  std::int64_t first = 0;
  for (std::int64_t shift = 0; shift + layout->n_slots <= expected; ++shift) {
    const double rms =
        fit_clocks(reference, times_by_pulse(train, *layout, shift, expected, origin), origin.has_value())
            .rms_ns;
    if (rms < best) {
      second = best;
      best = rms;
      first = shift;
    } else {
      second = std::min(second, rms);
    }
  }
  layout->placed = second > kClearlyBetter * best + kClockNoiseNs;
  if (layout->placed) layout->first = first;
}

/// Says what is wrong with one camera's train.
class TrainJudge {
 public:
  TrainJudge(const PulseTrain& train, const Layout& layout, int expected, double interval_ns,
             std::vector<PulseFault>* faults)
      : train_(train), layout_(layout), expected_(expected), interval_ns_(interval_ns), faults_(faults) {}

  void judge() {
    if (train_.frames.empty())
      return add(FaultKind::too_few, 0,
                 fmt::format("none of {} pulses came in camera \"{}\"", expected_, train_.camera));
    judge_count();
    judge_frames();
    judge_gaps();
  }

 private:
  void add(FaultKind kind, int pulse, const std::string& sentence) {
    faults_->push_back({kind, train_.camera, pulse, sentence});
  }
  void add_at(FaultKind kind, std::int64_t slot, const std::string& what) {
    add(kind, number(slot), fmt::format("{} {} in camera \"{}\"", name(slot), what, train_.camera));
  }
  int number(std::int64_t slot) const {
    return layout_.placed ? static_cast<int>(slot + layout_.first + 1) : 0;
  }
  std::string name(std::int64_t slot) const {
    return layout_.placed ? fmt::format("pulse {} of {}", number(slot), expected_)
                          : fmt::format("pulse {} from the first that came", slot + 1);
  }

  void judge_count() {
    const std::int64_t came = layout_.n_taken(), short_of = expected_ - layout_.n_slots;
    if (short_of < 0)
      return add(FaultKind::too_many, 0,
                 fmt::format("{} pulses were expected, {} came in camera \"{}\"", expected_, layout_.n_slots,
                             train_.camera));
    if (layout_.placed) {
      for (std::int64_t pulse = 0; pulse < expected_; ++pulse)
        if (pulse < layout_.first || pulse >= layout_.first + layout_.n_slots)
          add_at(FaultKind::missing, pulse - layout_.first, "is missing");
      return;
    }
    std::string which;
    // Every second pulse missing looks as regular as all of them.
    const bool known_inside = came - 1 > short_of;
    if (known_inside && short_of == 1) which = ": the first or the last is missing";
    if (known_inside && short_of > 1)
      which = fmt::format(": {} are missing at the beginning, at the end, or at both", short_of);
    add(FaultKind::too_few, 0,
        fmt::format("{} pulses were expected, {} came in camera \"{}\"{}", expected_, came, train_.camera,
                    which));
  }

  void judge_frames() {
    std::optional<std::size_t> before;  // the last whole pulse
    for (std::size_t i = 0; i < train_.frames.size(); ++i) {
      const std::string& fault = layout_.faults[i];
      if (fault == kDoubled)
        add_at(FaultKind::doubled, layout_.slots[i], "came twice");
      else if (fault == kIrregular)
        add_at(FaultKind::irregular, layout_.slots[i],
               fmt::format("came {:.4g} ms after the one before, the others {:.4g} ms",
                           before ? ms_between(*before, i) : 0.0, interval_ns_ / kNsPerMs));
      else if (!fault.empty())
        add_at(FaultKind::damaged, layout_.slots[i], "is damaged (" + fault + ")");
      if (fault.empty() || fault == kIrregular) before = i;
    }
  }
  double ms_between(std::size_t from, std::size_t to) const {
    return static_cast<double>(train_.frames[to].camera_ns - train_.frames[from].camera_ns) / kNsPerMs;
  }

  /// Missing pulses between two frames: the camera took none, or its frames were lost on the way.
  void judge_gaps() {
    for (std::size_t i = 1; i < train_.frames.size(); ++i) {
      std::int64_t lost = lost_before(i);
      const std::int64_t from = layout_.slots[i - 1], to = layout_.slots[i];
      for (std::int64_t slot = from + 1; slot < std::min(to, from + kMostMissingNamed); ++slot) {
        if (layout_.taken.contains(slot)) continue;
        if (lost > 0)
          add_at(FaultKind::lost, slot, "was lost on its way");
        else
          add_at(FaultKind::missing, slot, "is missing");
        --lost;
      }
      if (lost > 0)
        add(FaultKind::lost, 0,
            fmt::format("{} more frames than pulses were lost after {} in camera \"{}\"", lost, name(from),
                        train_.camera));
    }
  }
  std::int64_t lost_before(std::size_t i) const {
    const auto ahead = static_cast<std::int64_t>(train_.frames[i].block_id - train_.frames[i - 1].block_id);
    return std::max<std::int64_t>(ahead - 1, 0);
  }

  const PulseTrain& train_;
  const Layout& layout_;
  int expected_;
  double interval_ns_;
  std::vector<PulseFault>* faults_;
};

/// Two cameras on one line have the same times, but for their clocks.
void compare_cameras(const std::vector<PulseTrain>& trains, const std::vector<Layout>& layouts, int expected,
                     double interval_ns, PulseVerdict* verdict) {
  verdict->skew_ms.assign(static_cast<std::size_t>(expected), 0.0);
  for (std::size_t c = 1; c < trains.size(); ++c) {
    const std::optional<TimeNs> origin = shared_origin(trains[0], trains[c]);
    const ClockFit fit = fit_clocks(times_by_pulse(trains[0], layouts[0], layouts[0].first, expected, origin),
                                    times_by_pulse(trains[c], layouts[c], layouts[c].first, expected, origin),
                                    origin.has_value());
    // Of a short run, or by coarse clocks, the rate is not known well.
    const double gained = std::abs(fit.rate) * (expected - 1);
    if (std::abs(fit.rate) > kClockRate && gained > kOffInterval) {
      verdict->faults.push_back(
          {FaultKind::apart, trains[c].camera, 0,
           fmt::format("the pulses of camera \"{}\" come at {:.3f} times the interval of those of camera "
                       "\"{}\"",
                       trains[c].camera, 1.0 + fit.rate, trains[0].camera)});
      continue;
    }
    for (std::size_t k = 0; k < fit.left_ns.size(); ++k) {
      if (std::isnan(fit.left_ns[k])) continue;
      verdict->skew_ms[k] = std::max(verdict->skew_ms[k], std::abs(fit.left_ns[k]) / kNsPerMs);
      if (std::abs(fit.left_ns[k]) > kOffInterval * interval_ns)
        verdict->faults.push_back(
            {FaultKind::apart, trains[c].camera, static_cast<int>(k + 1),
             fmt::format("pulse {} of {} came {:.4g} ms apart in cameras \"{}\" and \"{}\"", k + 1, expected,
                         std::abs(fit.left_ns[k]) / kNsPerMs, trains[0].camera, trains[c].camera)});
    }
  }
}

}  // namespace

int PulseVerdict::count(PulseFault::Kind kind) const {
  return static_cast<int>(std::ranges::count(faults, kind, &PulseFault::kind));
}

std::string PulseVerdict::sentence() const {
  std::string text;
  for (std::size_t i = 0; i < std::min(faults.size(), kFaultsTold); ++i)
    text += (i == 0 ? "" : ", ") + faults[i].sentence;
  if (faults.size() > kFaultsTold) text += fmt::format(", and {} more", faults.size() - kFaultsTold);
  return text;
}

PulseVerdict judge_pulses(const std::vector<PulseTrain>& trains, int expected) {
  const double interval_ns = find_interval_ns(trains, expected);
  std::vector<Layout> layouts = lay_out(trains, interval_ns);
  std::optional<std::size_t> whole;
  for (std::size_t c = 0; c < trains.size(); ++c) {
    layouts[c].placed = layouts[c].n_slots == expected;
    if (!whole && layouts[c].placed && layouts[c].n_taken() == expected && layouts[c].n_irregular == 0)
      whole = c;
  }
  PulseVerdict verdict;
  if (interval_ns > 1.0) verdict.interval_ms = interval_ns / kNsPerMs;
  for (std::size_t c = 0; c < trains.size(); ++c) {
    const bool tells = layouts[c].n_taken() > 2 || (whole && shared_origin(trains[*whole], trains[c]));
    if (whole && !layouts[c].placed && tells)
      place_by_neighbour(trains[*whole], layouts[*whole], trains[c], expected, &layouts[c]);
    TrainJudge(trains[c], layouts[c], expected, interval_ns, &verdict.faults).judge();
    verdict.frame_faults.push_back(layouts[c].faults);
  }
  // A line that is dead comes first: what the others lack may follow from it.
  std::stable_partition(verdict.faults.begin(), verdict.faults.end(),
                        [](const PulseFault& fault) { return fault.kind == FaultKind::too_few; });
  if (trains.size() > 1 && verdict.right()) compare_cameras(trains, layouts, expected, interval_ns, &verdict);
  return verdict;
}

}  // namespace fringetwin::capture
