// SPDX-License-Identifier: Apache-2.0
// Reads and sets a GenICam camera's features by name; a value counts as set when the camera gives it back.
#pragma once
#include <map>
#include <set>
#include <string>
#include <vector>

#include "capture/genicam/genicam_module.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::capture {

/// "0...24 in steps of 0.1 dB", "Off, Once, Continuous".
std::string range_text(const GenicamFeature& feature);

class GenicamSettings {
 public:
  /// `camera`: as the user named it, "genicam:GV01".
  GenicamSettings(GenicamDevice& device, std::string camera) : device_(device), camera_(std::move(camera)) {}

  GenicamFeature feature(const std::string& name) const { return device_.feature(name); }
  /// Returns the feature's own name, case not regarded. Throws UserError(device), which names those that are
  /// like it.
  std::string own_name(const std::string& name) const;
  /// Returns the first of them that the camera has; "" when it has none.
  std::string first_of(const std::vector<std::string>& names) const;
  /// Returns the number that the feature has. Throws UserError(device) when it cannot be read.
  double number(const std::string& name) const;

  /// Throws UserError(device) unless the value is read back, numbers to half a step of theirs.
  void set(const std::string& name, const std::string& value) const;
  void set(const std::string& name, double value) const;
  /// Sets the feature where the camera has it and it can be written.
  void set_where_there(const std::string& name, const std::string& value) const;
  void execute(const std::string& command) const;
  /// Throws UserError(device) when it no longer has this value: one feature may move another.
  void verify(const std::string& name, const std::string& value) const;

  /// Turns off everything by which the camera changes its images on its own (every ...Auto that has "Off"),
  /// but for the features in `kept`. Returns the names of those it has.
  std::vector<std::string> turn_off_automatics(const std::set<std::string>& kept) const;

  /// Returns the values of those features that can be read, as "control.Gain" -> "0".
  std::map<std::string, std::string> provenance(const std::vector<std::string>& names) const;

  UserError refusal(const std::string& what, const std::string& hint = "") const {
    return {ExitCode::device, camera_, what, hint};
  }

 private:
  std::string accepted(const std::string& name, const GenicamFeature& feature,
                       const std::string& value) const;
  bool same(const GenicamFeature& now, const std::string& asked) const;

  GenicamDevice& device_;
  std::string camera_;
};

}  // namespace fringetwin::capture
