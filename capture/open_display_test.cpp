// SPDX-License-Identifier: Apache-2.0
#include "capture/open_display.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/display/window_display.hpp"
#include "tests/support/twin/expect_user_error.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::open_display_test {
namespace {

using namespace fringetwin::capture;
using ::testing::ElementsAre;
using testing::expect_user_error;
using ::testing::HasSubstr;

std::vector<std::string> shown;

// Shows at a time of its own: "fake:30" at 30 ns, "fake:t20" at 20 ns with a time stamp; "fake:w..." is
// wider.
class FakeDisplay : public PatternDisplay {
 public:
  FakeDisplay(const std::string& name, int width, int height) : name_(name), width_(width), height_(height) {
    if (name.find('w') != std::string::npos) ++width_;
  }
  DisplayInfo info() const override { return {name_, width_, height_, 8, timed(), {{"driver", "fake"}}}; }
  Shown show(const Pattern& pattern, const ImageF&) override {
    shown.push_back(name_ + " " + pattern.label);
    const TimeNs at_ns = std::stol(name_.substr(name_.find_first_of("0123456789")));
    return {at_ns, timed() ? 7U : 0U, timed()};
  }

 private:
  bool timed() const { return name_.find('t') != std::string::npos; }
  std::string name_;
  int width_, height_;
};

const DisplayFactories factories{{"fake", [](const std::string& name, int width, int height) {
                                    return std::make_unique<FakeDisplay>(name, width, height);
                                  }}};

TEST(OpenDisplay, ByTheKindBeforeTheColon) {
  const auto display = open_display("fake:t20", 64, 48, factories);
  EXPECT_EQ(display->info().device, "fake:t20");
  EXPECT_EQ(display->info().width, 64);
  EXPECT_TRUE(display->show(even_field(1.0, "white"), ImageF(64, 48)).timed);
}

TEST(OpenDisplay, UnknownKindsAreRefused) {
  for (const char* names : {"beamer", "", "fake:1+", "+fake:1", "fake:1++fake:2"})
    expect_user_error(ExitCode::usage, "is none of the kinds of display (fake)",
                      [&] { open_display(names, 64, 48, factories); });
  expect_user_error(ExitCode::usage, "window", [] { open_display("windows", 64, 48); });
}

TEST(OpenDisplay, NamesOfTheProgramsOwnKinds) {
  expect_user_error(ExitCode::usage, "window:x: is no screen", [] { open_display("window:x", 64, 48); });
  expect_user_error(ExitCode::usage, "window:-1: is no screen", [] { open_display("window:-1", 64, 48); });
  expect_user_error(ExitCode::usage, "kms@x: 'x' is no refresh rate", [] { open_display("kms@x", 64, 48); });
  expect_user_error(ExitCode::device, "/dev/dri/card99", [] { open_display("kms:/dev/dri/card99", 64, 48); });
  EXPECT_EQ(parse_window_name("window"), 0);
  EXPECT_EQ(parse_window_name("window:2"), 2);
}

TEST(MirrorDisplay, ShowsOnAllAndSaysTheLatest) {
  const auto display = open_display("fake:t20+fake:t90+fake:t50", 64, 48, factories);
  shown.clear();
  const Shown latest = display->show(even_field(1.0, "white"), ImageF(64, 48));
  EXPECT_THAT(shown, ElementsAre("fake:t20 white", "fake:t90 white", "fake:t50 white"));
  EXPECT_EQ(latest.at_ns, 90);
  EXPECT_TRUE(latest.timed);
  EXPECT_EQ(display->info().device, "fake:t20+fake:t90+fake:t50");
  EXPECT_EQ(display->info().provenance.at("2.driver"), "fake");
}

TEST(MirrorDisplay, IsTimedOnlyIfAllAre) {
  const auto display = open_display("fake:t90+fake:20", 64, 48, factories);
  EXPECT_FALSE(display->show(even_field(1.0, "white"), ImageF(64, 48)).timed);
  EXPECT_FALSE(display->info().timed);
}

TEST(MirrorDisplay, WantsOneSize) {
  expect_user_error(ExitCode::device, "fake:w1: has 65x48 pixels, fake:1 has 64x48",
                    [] { open_display("fake:1+fake:w1", 64, 48, factories); });
}

TEST(ListDisplays, SaysWhatThereIsWithoutThrowing) {
  for (const DisplayChoice& choice : list_displays()) {
    EXPECT_NE(choice.name, "");
    EXPECT_NE(choice.facts, "");
  }
}

}  // namespace
}  // namespace fringetwin::testing::open_display_test
