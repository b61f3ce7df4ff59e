// SPDX-License-Identifier: Apache-2.0
// The display on a card in software: what no driver of a virtual machine has (vertical blanking, gamma
// tables) and what drivers seldom do. tests/vm has the kernel's own.
#include "capture/display/kms_display.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>

#include "tests/support/capture/fake_drm.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::kms_display_test {
namespace {

using namespace fringetwin::capture;
using ::testing::ElementsAre;
using testing::FakeDrm;
using ::testing::HasSubstr;

class KmsDisplayTest : public ::testing::Test {
 protected:
  std::string path;
  FakeDrm& card = testing::new_fake_drm(&path);

  KmsDisplay open() { return KmsDisplay("kms:" + path, 1280, 720); }
  static Shown show(KmsDisplay& display) {
    return display.show(even_field(0.5, "gray"), ImageF(1280, 720, 0.5F));
  }
  std::string refusal() {
    try {
      open();
      return "nothing";
    } catch (const UserError& error) {
      EXPECT_EQ(error.code(), ExitCode::device);
      return error.what();
    }
  }
  void expect_fault(KmsDisplay& display, DeviceFault::Kind kind, const std::string& words) {
    try {
      show(display);
      ADD_FAILURE() << "no fault: " << words;
    } catch (const DeviceFault& fault) {
      EXPECT_EQ(fault.kind(), kind) << fault.what();
      EXPECT_THAT(fault.what(), HasSubstr(words));
    }
  }
  void expect_console() {
    EXPECT_EQ(card.buffer, FakeDrm::console);
    EXPECT_EQ(card.width, 1920);
    EXPECT_TRUE(card.buffers.empty());
    EXPECT_EQ(card.dumb_buffers, 0);
  }
};

TEST_F(KmsDisplayTest, FlipsAreTimedByTheDriverAcrossTheWrapOfItsCount) {
  {
    KmsDisplay display = open();
    EXPECT_TRUE(display.info().timed);
    EXPECT_EQ(card.width, 1280);
    std::uint64_t last = card.sequence;
    EXPECT_EQ(last, 0xffff'ffffULL);  // two flips to find out
    TimeNs last_ns = 0;
    for (int i = 0; i < 5; ++i) {
      const std::uint32_t front = card.buffer;
      const Shown shown = show(display);
      EXPECT_TRUE(shown.timed);
      EXPECT_EQ(shown.sequence, last + 1);
      // DRM's stamps are in whole us
      if (i > 0) {
        EXPECT_NEAR(static_cast<double>(shown.at_ns - last_ns), FakeDrm::period_ns, 1000.0);
      }
      EXPECT_NE(card.buffer, front) << "never into what is shown";
      last = shown.sequence;
      last_ns = shown.at_ns;
    }
    EXPECT_EQ(display.flips().missed(), 0u);
    card.late = 2;
    EXPECT_EQ(show(display).sequence, last + 3);
    EXPECT_EQ(display.flips().missed(), 2u);
    EXPECT_EQ(display.info().provenance.at("refresh_hz"), "60.0000");
    EXPECT_EQ(display.info().provenance.at("connector"), "HDMI-A-1");
  }
  expect_console();
}

TEST_F(KmsDisplayTest, WhatChangesLevelsIsOffAndComesBack) {
  {
    const KmsDisplay display = open();
    EXPECT_EQ(card.properties.at(FakeDrm::broadcast), 1u);  // full range
    EXPECT_EQ(card.properties.at(FakeDrm::scaling), 2u);    // there is no "None"
    EXPECT_EQ(card.properties.at(FakeDrm::gamma), 0u);
    EXPECT_EQ(card.properties.at(FakeDrm::dpms), 0u);
    EXPECT_EQ(display.info().provenance.at("set"),
              "scaling mode = Center, Broadcast RGB = Full, CTM off, GAMMA_LUT off");
    EXPECT_EQ(display.info().provenance.count("not_set"), 0u);
  }
  EXPECT_EQ(card.properties.at(FakeDrm::broadcast), 0u);
  EXPECT_EQ(card.properties.at(FakeDrm::scaling), 1u);
  EXPECT_THAT(card.blobs.at(static_cast<std::uint32_t>(card.properties.at(FakeDrm::gamma))),
              ElementsAre(1, 2, 3, 4, 5, 6, 7, 8));
}

TEST_F(KmsDisplayTest, OldDriversGetALinearGammaTable) {
  card.has_gamma_blob = false;
  {
    const KmsDisplay display = open();
    EXPECT_THAT(card.table, ElementsAre(0, 0x5555, 0xaaaa, 0xffff));
    EXPECT_THAT(display.info().provenance.at("set"), HasSubstr("linear gamma table"));
  }
  EXPECT_THAT(card.table, ElementsAre(9, 8, 7, 6));
}

TEST_F(KmsDisplayTest, WhatTheDriverKeepsIsSaid) {
  card.refuse_property = FakeDrm::broadcast;
  const KmsDisplay display = open();
  EXPECT_EQ(display.info().provenance.at("not_set"), "Broadcast RGB");
}

TEST_F(KmsDisplayTest, WithoutVerticalBlankingItIsUntimed) {
  card.counts_refreshes = false;
  KmsDisplay display = open();
  EXPECT_FALSE(display.info().timed);
  EXPECT_FALSE(show(display).timed);
}

TEST_F(KmsDisplayTest, RefusalsLeaveTheConsole) {
  card.other_master = true;
  EXPECT_THAT(refusal(), HasSubstr("another program holds this card"));
  expect_console();
  card.other_master = false;
  card.connected = false;
  EXPECT_THAT(refusal(), HasSubstr("no display is connected (its connectors: HDMI-A-1 not connected)"));
  expect_console();
  card.connected = true;
  card.mode_error = EINVAL;
  EXPECT_THAT(refusal(), HasSubstr("the mode 1280x720 at 60.00 Hz cannot be set (Invalid argument)"));
  expect_console();
  card.mode_error = 0;
  card.flip_error = EINVAL;
  EXPECT_THAT(refusal(), HasSubstr("shows no second picture"));
  expect_console();
  EXPECT_EQ(card.properties.at(FakeDrm::broadcast), 0u);
  card.flip_error = 0;
  EXPECT_EQ(refusal(), "nothing");
}

TEST_F(KmsDisplayTest, FaultsWhileRunningTellWhatANewTryCanMend) {
  {
    KmsDisplay display = open();
    card.flip_error = EACCES;
    expect_fault(display, DeviceFault::Kind::stream, "another program has taken the display");
    card.flip_error = ENODEV;
    expect_fault(display, DeviceFault::Kind::gone, "the graphics card is gone");
    card.flip_error = 0;
    EXPECT_TRUE(show(display).timed) << "back again";
    card.answers = false;
    expect_fault(display, DeviceFault::Kind::timeout, "no page flip within 2000 ms");
    card.answers = true;
    EXPECT_NO_THROW(show(display)) << "back again";
    card.connected = false;
    expect_fault(display, DeviceFault::Kind::gone, "unplugged");
    EXPECT_THROW(display.check(), DeviceFault);
  }
  expect_console();
}

}  // namespace
}  // namespace fringetwin::testing::kms_display_test
