// SPDX-License-Identifier: Apache-2.0
// Windows on a virtual X server: every pixel of the screen against the quantised pattern.
#include "capture/display/window_display.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <thread>

#include "capture/open_display.hpp"
#include "tests/support/capture/x11_client.hpp"
#include "tests/support/capture/xvfb.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::window_display_test {
namespace {

using namespace fringetwin::capture;
using ::testing::HasSubstr;
using testing::Xvfb;

Fringes two_directions() {
  Fringes fringes;
  for (const Axis axis : {Axis::x, Axis::y}) {
    DirectionFringes direction;
    direction.axis = axis;
    direction.pitches_px = {13, 14.5};
    direction.phase_origin_px = {0, 0};
    fringes.directions.push_back(direction);
  }
  fringes.steps = 3;
  return fringes;
}

ImageF checkerboard(int width, int height) {
  ImageF levels(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) levels(x, y) = static_cast<float>((x + y) % 2);
  return levels;
}

// Every level of 8 bits, at the edge of rounding too.
ImageF all_levels(int width, int height) {
  ImageF levels(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) levels(x, y) = static_cast<float>((x * 7 + y * 3) % 1021) / 1020.0F;
  return levels;
}

std::size_t wrong_pixels(const Image<std::uint32_t>& screen, const ImageF& levels) {
  const ImageU16 expected = quantise_levels(levels, 8);
  if (!screen.same_size(expected)) return expected.size();
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) wrong += screen.data[i] != expected.data[i] * 0x010101U;
  return wrong;
}

TEST(WindowDisplay, ShowsEveryPatternPixelForPixel) {
  const Xvfb server({{1280, 720}});
  FT_NEED_XVFB(server.started());
  const auto display = open_display("window", 1280, 720);
  EXPECT_EQ(wrong_pixels(server.screen(0), ImageF(1280, 720)), 0u) << "black until the first pattern";
  const Fringes fringes = two_directions();
  const std::vector<Pattern> patterns = sequence_patterns(fringes);
  ASSERT_EQ(patterns.size(), 12u);
  for (const Pattern& pattern : patterns) {
    const ImageF levels = pattern_levels(fringes, pattern, 1280, 720);
    const TimeNs before_ns = steady_now_ns();
    const Shown shown = display->show(pattern, levels);
    EXPECT_EQ(wrong_pixels(server.screen(0), levels), 0u) << pattern.label;
    EXPECT_FALSE(shown.timed);
    EXPECT_GE(shown.at_ns, before_ns);
    EXPECT_LE(shown.at_ns, steady_now_ns());
  }
  for (const ImageF& levels : {checkerboard(1280, 720), all_levels(1280, 720), ImageF(1280, 720, 1.0F)}) {
    display->show(even_field(0, "test"), levels);
    EXPECT_EQ(wrong_pixels(server.screen(0), levels), 0u);
  }
}

// The check can fail: a neighbouring level in one pixel is seen.
TEST(WindowDisplay, OneWrongPixelWouldBeSeen) {
  const Xvfb server({{320, 200}});
  FT_NEED_XVFB(server.started());
  const auto display = open_display("window", 320, 200);
  ImageF levels = all_levels(320, 200);
  display->show(even_field(0, "test"), levels);
  ASSERT_EQ(wrong_pixels(server.screen(0), levels), 0u);
  levels(319, 199) += levels(319, 199) > 0.5F ? -1.0F / 255.0F : 1.0F / 255.0F;
  EXPECT_EQ(wrong_pixels(server.screen(0), levels), 1u);
}

TEST(WindowDisplay, OddSizesHaveNoScaling) {
  const Xvfb server({{917, 613}});
  FT_NEED_XVFB(server.started());
  const auto display = open_display("window", 917, 613);
  display->show(even_field(0, "test"), checkerboard(917, 613));
  EXPECT_EQ(wrong_pixels(server.screen(0), checkerboard(917, 613)), 0u);
}

// What the environment asks SDL for is used, and shows the same pixels.
TEST(WindowDisplay, OpenGlShowsTheSamePixels) {
  const Xvfb server({{640, 480}});
  FT_NEED_XVFB(server.started());
  ::setenv("SDL_RENDER_DRIVER", "opengl", 1);
  const auto display = open_display("window", 640, 480);
  ::unsetenv("SDL_RENDER_DRIVER");
  EXPECT_THAT(display->info().provenance.at("driver"), HasSubstr("opengl"));
  for (const ImageF& levels : {checkerboard(640, 480), all_levels(640, 480)}) {
    display->show(even_field(0, "test"), levels);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));  // its server draws when it likes to
    EXPECT_EQ(wrong_pixels(server.screen(0), levels), 0u);
  }
}

TEST(WindowDisplay, AnotherSizeIsRefusedNamingBoth) {
  const Xvfb server({{1280, 720}});
  FT_NEED_XVFB(server.started());
  try {
    open_display("window", 912, 1140);
    FAIL() << "not refused";
  } catch (const UserError& error) {
    EXPECT_EQ(error.code(), ExitCode::device);
    EXPECT_THAT(error.what(), HasSubstr("1280x720 pixels, the projector 912x1140"));
  }
  try {
    open_display("window:3", 1280, 720);
    FAIL() << "not refused";
  } catch (const UserError& error) {
    EXPECT_EQ(error.code(), ExitCode::device);
    EXPECT_THAT(error.what(), HasSubstr("there is no screen 3: the desktop has 1"));
  }
}

TEST(WindowDisplay, WithoutADesktopItIsRefused) {
  ::setenv("SDL_VIDEODRIVER", "x11", 1);
  ::setenv("DISPLAY", ":4095", 1);
  try {
    open_display("window", 640, 480);
    ADD_FAILURE() << "not refused";
  } catch (const UserError& error) {
    EXPECT_EQ(error.code(), ExitCode::device);
    EXPECT_THAT(error.what(), HasSubstr("window: a window cannot be opened"));
  }
  ::unsetenv("DISPLAY");
}

// SDL would take its own "offscreen" driver, whose pictures nobody sees.
TEST(WindowDisplay, WithoutAnyDesktopNothingIsDrawnIntoTheVoid) {
  for (const char* name : {"SDL_VIDEODRIVER", "DISPLAY", "WAYLAND_DISPLAY"}) ::unsetenv(name);
  try {
    open_display("window", 1024, 768);
    ADD_FAILURE() << "not refused";
  } catch (const UserError& error) {
    EXPECT_EQ(error.code(), ExitCode::device);
    EXPECT_THAT(error.what(), HasSubstr("neither DISPLAY nor WAYLAND_DISPLAY"));
  }
}

// Xvfb has no two monitors, but two windows on one thread it has; the upper one is seen.
TEST(WindowDisplay, TwoWindowsShowTheSame) {
  const Xvfb server({{640, 480}});
  FT_NEED_XVFB(server.started());
  const auto display = open_display("window:0+window:0", 640, 480);
  for (const ImageF& levels : {checkerboard(640, 480), all_levels(640, 480)}) {
    display->show(even_field(0, "test"), levels);
    EXPECT_EQ(wrong_pixels(server.screen(0), levels), 0u);
  }
}

// SDL lists X screens that are no monitors of one desktop, but puts every window on the first.
TEST(WindowDisplay, AWindowOnTheWrongScreenIsRefused) {
  const Xvfb server({{640, 480}, {640, 480}});
  FT_NEED_XVFB(server.started());
  try {
    open_display("window:1", 640, 480);
    FAIL() << "not refused";
  } catch (const UserError& error) {
    EXPECT_EQ(error.code(), ExitCode::device);
    EXPECT_THAT(error.what(), HasSubstr("the desktop put it on screen 0"));
  }
}

// 0 when the end of the desktop is a fault of the device, now and later.
int show_until_the_desktop_ends(Xvfb& server) {
  const auto display = open_display("window", 640, 480);
  server.end();
  try {
    for (int tries = 0; tries < 100; ++tries) {
      display->show(even_field(1, "white"), ImageF(640, 480, 1.0F));
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return 2;
  } catch (const DeviceFault& fault) {
    if (fault.kind() != DeviceFault::Kind::gone) return 3;
  }
  try {
    display->check();
    return 4;
  } catch (const DeviceFault& fault) {
    return fault.kind() == DeviceFault::Kind::gone ? 0 : 5;
  }
}

TEST(WindowDisplay, TheEndOfTheDesktopIsAFaultOfTheDevice) {
  Xvfb server({{640, 480}});
  FT_NEED_XVFB(server.started());
  // in a process of its own, which cannot have another desktop after that
  EXPECT_EXIT(std::exit(show_until_the_desktop_ends(server)), ::testing::ExitedWithCode(0), "");
}

TEST(WindowDisplay, IsRepaintedWhenSomethingWasOverIt) {
  const Xvfb server({{640, 480}});
  FT_NEED_XVFB(server.started());
  const auto display = open_display("window", 640, 480);
  const ImageF levels = all_levels(640, 480);
  display->show(even_field(0, "test"), levels);
  ASSERT_TRUE(testing::cover_and_uncover(server.display()));
  std::size_t wrong = 1;
  for (int tries = 0; wrong && tries < 100; ++tries) {  // without any call of the display's
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    wrong = wrong_pixels(server.screen(0), levels);
  }
  EXPECT_EQ(wrong, 0u);
}

void expect_cancelled(PatternDisplay& display) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(5);
  try {
    while (std::chrono::steady_clock::now() < end) {
      display.check();
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ADD_FAILURE() << "not cancelled";
  } catch (const Cancelled&) {
  }
  EXPECT_THROW(display.show(even_field(1, "white"), ImageF(640, 480, 1.0F)), Cancelled);
}

TEST(WindowDisplay, ClosingItCancels) {
  const Xvfb server({{640, 480}});
  FT_NEED_XVFB(server.started());
  const auto display = open_display("window", 640, 480);
  EXPECT_NO_THROW(display->check());
  ASSERT_TRUE(testing::ask_window_to_close(server.display()));
  expect_cancelled(*display);
}

TEST(WindowDisplay, EscapeCancels) {
  const Xvfb server({{640, 480}});
  FT_NEED_XVFB(server.started());
  const auto display = open_display("window", 640, 480);
  ASSERT_TRUE(testing::press_escape(server.display()));
  expect_cancelled(*display);
}

TEST(WindowDisplay, IsListed) {
  const Xvfb server({{1280, 720}});
  FT_NEED_XVFB(server.started());
  std::string found;
  for (const DisplayChoice& choice : list_displays())
    if (choice.name == "window:0") found = choice.facts;
  EXPECT_THAT(found, HasSubstr("1280x720"));
}

}  // namespace
}  // namespace fringetwin::testing::window_display_test
