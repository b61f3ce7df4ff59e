// SPDX-License-Identifier: Apache-2.0
// QEMU's monitor as the guest reaches it, over its second serial port: what the virtual displays show is seen
// from outside.
#pragma once
#include <cstdint>
#include <string>

#include "twin/image/image.hpp"

namespace fringetwin::testing {

class Monitor {
 public:
  Monitor();  ///< throws std::runtime_error when there is none
  ~Monitor();
  Monitor(const Monitor&) = delete;
  Monitor& operator=(const Monitor&) = delete;

  /// Returns when QEMU has done it, with what it printed.
  std::string command(const std::string& line);
  /// 0xRRGGBB per pixel, of the display device of that id (QEMU's -device ...,id=). The file stays beside the
  /// console's log.
  Image<std::uint32_t> screen(const std::string& device, const std::string& file);

 private:
  std::string read_answer();
  int fd_ = -1;
};

}  // namespace fringetwin::testing
