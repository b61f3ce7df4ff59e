// SPDX-License-Identifier: Apache-2.0
// One point of a study, a virtual measurement with its settings and seed, and what came of running it.
#pragma once
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace fringetwin::study {

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();  ///< what does not exist

/// Limits of every kind of study: virtual measurements in all, and the greatest seed.
inline constexpr int kMostPoints = 1'000'000, kMostSeed = 2'000'000'000;

/// Values put into the twin's keys before it is read, as TOML text: "camera.left.sensor.bit_depth" -> "12".
/// Cameras and objects are found by name; arrays by index ("fringes.pitches_px[0]").
using Settings = std::map<std::string, std::string>;

/// One virtual measurement: a point of the design with one seed of the noise.
struct StudyPoint {
  std::int64_t id = 0;  ///< counts from 0 in the order of the design, seeds fastest
  Settings settings;
  std::uint64_t seed = 0;
};

/// Points in their order, each made when it is asked for: the values of a million, as text, fill gigabytes.
class PointSequence {
 public:
  PointSequence() = default;
  PointSequence(std::size_t size, std::function<StudyPoint(std::size_t)> make)
      : size_(size), make_(std::make_shared<std::function<StudyPoint(std::size_t)>>(std::move(make))) {}
  PointSequence(std::vector<StudyPoint> points)
      : size_(points.size()),
        make_(std::make_shared<std::function<StudyPoint(std::size_t)>>(
            [kept = std::move(points)](std::size_t i) { return kept[i]; })) {}
  PointSequence(std::initializer_list<StudyPoint> points) : PointSequence(std::vector<StudyPoint>(points)) {}

  std::size_t size() const { return size_; }
  StudyPoint operator[](std::size_t i) const { return (*make_)(i); }

  struct Iterator {
    const PointSequence* points;
    std::size_t i;
    StudyPoint operator*() const { return (*points)[i]; }
    Iterator& operator++() { return ++i, *this; }
    bool operator==(const Iterator&) const = default;
  };
  Iterator begin() const { return {this, 0}; }
  Iterator end() const { return {this, size_}; }

 private:
  std::size_t size_ = 0;
  std::shared_ptr<const std::function<StudyPoint(std::size_t)>> make_;
};

struct PointOutcome {
  std::int64_t id = 0;
  bool failed = false;
  std::string reason = {};                     ///< of a failure, one sentence
  std::map<std::string, double> numbers = {};  ///< recorded results by name; NaN where a result has none
  double seconds = 0.0;
  bool traced = true;             ///< false: the light came from another point's trace
  std::string host{}, version{};  ///< where it ran and by which program; empty: here, by this one
  /// What was said of its fits: measure::Measurement::gate_warnings. Not kept in the store.
  std::vector<std::string> gate_warnings{};

  /// Returns the recorded number; NaN also where it was not recorded.
  double number(const std::string& name) const {
    const auto at = numbers.find(name);
    return at == numbers.end() ? kNan : at->second;
  }
};

/// Runs points and returns their outcomes in any order; one that is missing counts as failed.
using RunPoints = std::function<std::vector<PointOutcome>(const std::vector<StudyPoint>&)>;

}  // namespace fringetwin::study
