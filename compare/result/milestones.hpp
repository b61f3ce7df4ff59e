// SPDX-License-Identifier: Apache-2.0
// Shows the progress of work whose steps are unequal, and may turn out to be fewer than there might have
// been.
#pragma once
#include <cstddef>
#include <string>
#include <utility>

#include "twin/base/progress.hpp"

namespace fringetwin::compare {

/// Shows what Progress does of a task of `total` parts, by how many of them are behind it.
class Milestones {
 public:
  Milestones(std::string task, std::size_t total) : progress_(std::move(task), total), total_(total) {}
  /// Goes on to `done` parts, where it is not yet. Throws Cancelled once the user pressed Ctrl-C.
  void reach(std::size_t done) {
    const std::size_t more = done > done_ ? done - done_ : 0;
    done_ += more;
    progress_.advance(more);
  }
  /// Goes on by one part.
  void step() { reach(done_ + 1); }
  /// Goes on to the end.
  void finish() { reach(total_); }

 private:
  Progress progress_;
  std::size_t total_, done_ = 0;
};

}  // namespace fringetwin::compare
