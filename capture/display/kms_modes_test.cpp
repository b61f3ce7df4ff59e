// SPDX-License-Identifier: Apache-2.0
#include "capture/display/kms_modes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>

#include "capture/display/kms_card.hpp"
#include "tests/support/twin/expect_user_error.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::kms_modes_test {
namespace {

using capture::choose_connector;
using capture::choose_mode;
using capture::DeviceFault;
using capture::KmsConnector;
using capture::KmsMode;
using capture::parse_kms_name;
using testing::expect_user_error;
using ::testing::HasSubstr;

TEST(KmsName, HasACardAConnectorAndARate) {
  EXPECT_EQ(parse_kms_name("kms").card, "");
  EXPECT_FALSE(parse_kms_name("kms").refresh_hz);
  EXPECT_EQ(parse_kms_name("kms:/dev/dri/card1").card, "/dev/dri/card1");
  const capture::KmsName all = parse_kms_name("kms:/dev/dri/card1:HDMI-A-1@59.94");
  EXPECT_EQ(all.card, "/dev/dri/card1");
  EXPECT_EQ(all.connector, "HDMI-A-1");
  EXPECT_DOUBLE_EQ(*all.refresh_hz, 59.94);
  EXPECT_DOUBLE_EQ(*parse_kms_name("kms@60").refresh_hz, 60.0);
}

TEST(KmsName, OthersAreRefused) {
  for (const char* name : {"kms@", "kms@fast", "kms@-60", "kms@60Hz", "kms:", "kms:/dev/dri/card0:", "kmsx",
                           "window", "", "kms::HDMI-A-1"})
    expect_user_error(ExitCode::usage, name, [&] { parse_kms_name(name); });
}

const std::vector<KmsMode> modes{
    {1920, 1080, 60.0, true, true},  {1920, 1080, 59.94, false, true}, {1920, 1080, 120.0, false, true},
    {1280, 720, 59.94, false, true}, {1280, 720, 120.0, false, true},  {1280, 720, 60.0, false, true},
    {1440, 576, 50.0, false, false},
};

TEST(KmsModes, ThePreferredElseTheFastestOfTheSize) {
  EXPECT_EQ(choose_mode(modes, 1920, 1080, std::nullopt, "card"), 0u);
  EXPECT_EQ(choose_mode(modes, 1280, 720, std::nullopt, "card"), 4u);
}

TEST(KmsModes, TheRateAskedForAndNoneNearIt) {
  EXPECT_EQ(choose_mode(modes, 1920, 1080, 59.94, "card"), 1u);
  EXPECT_EQ(choose_mode(modes, 1920, 1080, 120.0, "card"), 2u);
  EXPECT_EQ(choose_mode(modes, 1280, 720, 60.0, "card"), 5u);
  expect_user_error(ExitCode::device, "1280x720 pixels at 50 Hz",
                    [] { choose_mode(modes, 1280, 720, 50.0, "card"); });
}

TEST(KmsModes, AnotherSizeIsRefusedWithTheModesThereAre) {
  expect_user_error(
      ExitCode::device,
      "card0:HDMI-A-1: has no mode of the projector's 912x1140 pixels; its modes: 1920x1080@60.00 "
      "1920x1080@59.94 1920x1080@120.00 1280x720@59.94 1280x720@120.00 1280x720@60.00 "
      "1440x576i@50.00; patterns are never scaled",
      [] { choose_mode(modes, 912, 1140, std::nullopt, "card0:HDMI-A-1"); });
  expect_user_error(ExitCode::device, "its modes: none",
                    [] { choose_mode({}, 912, 1140, std::nullopt, "card0:HDMI-A-1"); });
}

TEST(KmsModes, InterlacedModesAreNeverChosen) {
  expect_user_error(ExitCode::device, "no mode of the projector's 1440x576",
                    [] { choose_mode(modes, 1440, 576, std::nullopt, "card"); });
}

TEST(KmsConnectors, TheFirstConnectedOrTheOneNamed) {
  const std::vector<KmsConnector> connectors{{"DP-1", false, {}}, {"HDMI-A-1", true, {}}, {"DP-2", true, {}}};
  EXPECT_EQ(choose_connector(connectors, "", "card0"), 1u);
  EXPECT_EQ(choose_connector(connectors, "DP-2", "card0"), 2u);
  expect_user_error(ExitCode::device, "DP-1 not connected, HDMI-A-1 connected, DP-2 connected",
                    [&] { choose_connector(connectors, "DP-1", "card0"); });
  expect_user_error(ExitCode::device, "DP-9 is not there",
                    [&] { choose_connector(connectors, "DP-9", "card0"); });
  expect_user_error(ExitCode::device, "no display is connected (its connectors: DP-1 not connected)", [] {
    choose_connector({{"DP-1", false, {}}}, "", "card0");
  });
  expect_user_error(ExitCode::device, "no connectors", [] { choose_connector({}, "", "card0"); });
}

TEST(KmsFaults, TellWhatANewTryCanMend) {
  const auto kind = [](int error) { return capture::kms_fault(error, "card0", "page flip").kind(); };
  EXPECT_EQ(kind(ENODEV), DeviceFault::Kind::gone);
  EXPECT_EQ(kind(EACCES), DeviceFault::Kind::stream);
  EXPECT_EQ(kind(EBUSY), DeviceFault::Kind::stream);
  EXPECT_EQ(kind(ETIMEDOUT), DeviceFault::Kind::timeout);
  EXPECT_EQ(kind(EINVAL), DeviceFault::Kind::stream);
  EXPECT_THAT(capture::kms_fault(EACCES, "card0", "page flip").what(), HasSubstr("another program"));
}

TEST(KmsCard, AMissingCardIsRefused) {
  expect_user_error(ExitCode::device, "/dev/dri/card99: cannot be opened (No such file or directory)",
                    [] { capture::KmsCard::open("/dev/dri/card99"); });
  expect_user_error(ExitCode::device, "/dev/null: is no graphics card with displays",
                    [] { capture::KmsCard::open("/dev/null"); });
}

TEST(KmsPeriod, IsThatOfTheClock) {
  drmModeModeInfo mode{};  // CEA-861's 1280x720
  mode.clock = 74250;
  mode.htotal = 1650;
  mode.vtotal = 750;
  EXPECT_DOUBLE_EQ(capture::mode_period_ns(mode), 1e9 / 60.0);
  mode.clock = 0;
  mode.vrefresh = 50;
  EXPECT_DOUBLE_EQ(capture::mode_period_ns(mode), 2e7);
}

}  // namespace
}  // namespace fringetwin::testing::kms_modes_test
