// SPDX-License-Identifier: Apache-2.0
// A virtual X server whose screens are files: what a window shows is read without asking X. For *_test.cpp
// only.
#pragma once
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/twin/child_process.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::testing {

/// Ends with the object. DISPLAY names it meanwhile.
class Xvfb {
 public:
  /// One screen of each size.
  explicit Xvfb(const std::vector<std::array<int, 2>>& sizes) {
    std::array<int, 2> number{};
    if (::pipe(number.data()) != 0) return;
    std::vector<std::string> words{"Xvfb",      "-noreset", "-displayfd", std::to_string(number[1]),
                                   "-nolisten", "tcp",      "-fbdir",     folder_.path().string()};
    for (std::size_t i = 0; i < sizes.size(); ++i) {
      words.insert(words.end(), {"-screen", std::to_string(i)});
      words.push_back(std::to_string(sizes[i][0]) + "x" + std::to_string(sizes[i][1]) + "x24");
    }
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    if (::posix_spawnp(&process_, "Xvfb", nullptr, nullptr, arguments.data(), environ) != 0) process_ = -1;
    ::close(number[1]);
    char digit = 0;
    while (::read(number[0], &digit, 1) == 1 && digit != '\n') display_ += digit;
    ::close(number[0]);
    if (display_.empty()) return;
    display_.insert(0, ":");
    ::setenv("DISPLAY", display_.c_str(), 1);
    ::setenv("SDL_VIDEODRIVER", "x11", 1);
  }
  ~Xvfb() { end(); }
  Xvfb(const Xvfb&) = delete;
  Xvfb& operator=(const Xvfb&) = delete;

  bool started() const { return !display_.empty(); }
  const std::string& display() const { return display_; }
  void end() {
    if (process_ > 0) {
      ::kill(process_, SIGTERM);
      ::waitpid(process_, nullptr, 0);
    }
    process_ = -1;
    ::unsetenv("DISPLAY");
  }

  /// The screen as it is now, 0xRRGGBB per pixel; empty if its file is none of 32 bits per pixel.
  Image<std::uint32_t> screen(int number) const {
    const std::string file = read_file(folder_ / ("Xvfb_screen" + std::to_string(number)));
    const auto word = [&](std::size_t i) {  // XWD's header: big-endian words
      std::uint32_t value = 0;
      for (std::size_t k = 0; k < 4; ++k) value = value << 8 | static_cast<std::uint8_t>(file.at(4 * i + k));
      return value;
    };
    constexpr std::size_t header = 0, width = 4, height = 5, byte_order = 7, bits = 11, line = 12,
                          colours = 19;
    if (file.size() < 100 || word(bits) != 32 || word(byte_order) != 0) return {};
    Image<std::uint32_t> image(static_cast<int>(word(width)), static_cast<int>(word(height)));
    const std::size_t begin = word(header) + std::size_t{12} * word(colours);
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        const std::size_t at =
            begin + static_cast<std::size_t>(y) * word(line) + 4 * static_cast<std::size_t>(x);
        for (std::size_t k = 3; k-- > 0;)
          image(x, y) = image(x, y) << 8 | static_cast<std::uint8_t>(file.at(at + k));
      }
    return image;
  }

 private:
  ScratchFolder folder_;
  pid_t process_ = -1;
  std::string display_;
};

}  // namespace fringetwin::testing

/// Skips the test in whose body it stands where `server_started` says that there is no Xvfb; there it fails
/// when devices are required.
#define FT_NEED_XVFB(server_started)                                                          \
  if (!(server_started)) {                                                                    \
    ASSERT_FALSE(std::getenv("CI") || std::getenv("FRINGETWIN_REQUIRE_DEVICE")) << "no Xvfb"; \
    GTEST_SKIP() << "SKIPPED: no Xvfb";                                                       \
  }
