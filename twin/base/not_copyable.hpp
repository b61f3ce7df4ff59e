// SPDX-License-Identifier: Apache-2.0
// The base of classes whose objects stand for one thing outside, such as an open file: they are not copied.
#pragma once

namespace fringetwin {

class NotCopyable {
 public:
  NotCopyable(const NotCopyable&) = delete;
  NotCopyable& operator=(const NotCopyable&) = delete;

 protected:
  NotCopyable() = default;
};

}  // namespace fringetwin
