// SPDX-License-Identifier: Apache-2.0
// vivid_control setup N: instances 0...N-1 show on their capture what their output plays, at the rate of the
// tests. vivid_control push|set I CONTROL [VALUE]: a button or a value of instance I, also while it streams.
#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <vector>

#include "tests/vm/vivid.hpp"

namespace fringetwin::testing {
namespace {

void control(const std::vector<std::string>& words) {
  const capture::V4l2Device device(capture::kernel_v4l2(),
                                   fmt::format("/dev/video{}", 2 * std::stoi(words.at(1))),
                                   V4L2_CAP_VIDEO_CAPTURE);
  const capture::V4l2Controls controls(device);
  if (words.at(0) == "push")
    controls.push(controls.named(words.at(2)));
  else
    controls.set(controls.named(words.at(2)), words.at(3));
}

}  // namespace
}  // namespace fringetwin::testing

int main(int argc, char** argv) {
  try {
    const std::vector<std::string> words(argv + 1, argv + argc);
    if (words.at(0) != "setup") fringetwin::testing::control(words);
    if (words.at(0) == "setup")
      for (int i = 0; i < std::stoi(words.at(1)); ++i) fringetwin::testing::Vivid{i};
  } catch (const std::exception& error) {
    std::fprintf(stderr, "vivid_control: %s\n", error.what());
    return 1;
  }
}
