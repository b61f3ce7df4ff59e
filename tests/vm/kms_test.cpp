// SPDX-License-Identifier: Apache-2.0
// Page flips with the kernel's drivers for QEMU's virtio-gpu (card0) and bochs-display (card1); their screens
// as QEMU sees them. Neither driver has vertical blanking: page_flips_test.cpp has what stamps say.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <xf86drmMode.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "capture/display/kms_card.hpp"
#include "capture/display/kms_display.hpp"
#include "capture/open_display.hpp"
#include "tests/vm/monitor.hpp"
#include "tests/vm/vivid.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::kms_test {
namespace {

using namespace fringetwin::capture;
using ::testing::HasSubstr;

// Numbers of cards follow the order of loading; QEMU's ids are those of CMakeLists.txt.
struct Gpu {
  const char *card, *id, *driver;
};
constexpr Gpu virtio{"/dev/dri/card0", "virtio", "virtio_gpu"};
constexpr Gpu bochs{"/dev/dri/card1", "bochs", "bochs-drm"};

ImageF checkerboard(int width, int height) {
  ImageF levels(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) levels(x, y) = static_cast<float>((x + y) % 2);
  return levels;
}

// FRINGETWIN_VM_WRONG: expects one pixel one level off, to show that these tests can fail.
std::size_t wrong_pixels(const Image<std::uint32_t>& screen, const ImageF& levels) {
  ImageU16 expected = quantise_levels(levels, 8);
  if (std::getenv("FRINGETWIN_VM_WRONG") != nullptr) expected(640, 360) ^= 1;
  if (!screen.same_size(expected)) return expected.size();
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) wrong += screen.data[i] != expected.data[i] * 0x010101U;
  return wrong;
}

template <class Call>
std::string refusal(const Call& call) {
  try {
    call();
    return "nothing";
  } catch (const UserError& error) {
    EXPECT_EQ(error.code(), ExitCode::device);
    return error.what();
  }
}

class KmsPatterns : public ::testing::TestWithParam<Gpu> {};

TEST_P(KmsPatterns, AreOnTheScreenPixelForPixel) {
  const Gpu gpu = GetParam();
  Monitor monitor;
  KmsDisplay display(std::string("kms:") + gpu.card, 1280, 720);
  EXPECT_EQ(wrong_pixels(monitor.screen(gpu.id, "shot.ppm"), ImageF(1280, 720)), 0u) << "black at first";
  const Fringes fringes = vivid_fringes();
  int exact = 0;
  TimeNs slowest_ns = 0;
  for (const Pattern& pattern : sequence_patterns(fringes)) {
    const ImageF levels = pattern_levels(fringes, pattern, 1280, 720);
    const TimeNs before_ns = steady_now_ns();
    const Shown shown = display.show(pattern, levels);
    slowest_ns = std::max(slowest_ns, steady_now_ns() - before_ns);
    EXPECT_FALSE(shown.timed);
    EXPECT_GE(shown.at_ns, before_ns);
    exact += wrong_pixels(monitor.screen(gpu.id, std::string(gpu.id) + ".ppm"), levels) == 0;
  }
  EXPECT_EQ(exact, 8);
  display.show(even_field(0, "checkerboard"), checkerboard(1280, 720));
  EXPECT_EQ(wrong_pixels(monitor.screen(gpu.id, "shot.ppm"), checkerboard(1280, 720)), 0u);
  EXPECT_EQ(display.flips().count(), 9u);  // each with its event
  std::printf("%s: %d of 8 exact, at most %.1f ms from levels to flip\n", gpu.driver, exact,
              1e-6 * static_cast<double>(slowest_ns));
  const DisplayInfo info = display.info();
  EXPECT_FALSE(info.timed);
  EXPECT_THAT(info.provenance.at("driver"), HasSubstr(gpu.driver));
  EXPECT_EQ(info.provenance.at("timing"), "the driver does not count refreshes");
  for (const auto& [key, value] : info.provenance) std::printf("  %s = %s\n", key.c_str(), value.c_str());
}

INSTANTIATE_TEST_SUITE_P(Drivers, KmsPatterns, ::testing::Values(virtio, bochs),
                         [](const auto& each) { return std::string(each.param.id); });

TEST(KmsMirror, TwoCardsShowTheSame) {
  Monitor monitor;
  const auto display = open_display("kms:/dev/dri/card0+kms:/dev/dri/card1", 1280, 720);
  const ImageF levels = checkerboard(1280, 720);
  display->show(even_field(0, "checkerboard"), levels);
  for (const Gpu& gpu : {virtio, bochs})
    EXPECT_EQ(wrong_pixels(monitor.screen(gpu.id, "shot.ppm"), levels), 0u) << gpu.id;
}

// Mode and buffer of the card's first CRTC.
std::string crtc_state(const char* card_path) {
  const auto card = KmsCard::open(card_path);
  const DrmResources resources(drmModeGetResources(card->fd()));
  const DrmCrtc crtc(drmModeGetCrtc(card->fd(), resources->crtcs[0]));
  return std::string(crtc->mode_valid ? crtc->mode.name : "off") + " of buffer " +
         std::to_string(crtc->buffer_id);
}

TEST(KmsModes, TheConsoleComesBackAtTheEnd) {
  Monitor monitor;
  const std::string before = crtc_state(virtio.card);
  EXPECT_THAT(before, HasSubstr("1280x720 of buffer"));
  {
    const KmsDisplay display("kms", 1024, 768);
    EXPECT_THAT(crtc_state(virtio.card), HasSubstr("1024x768"));
    const Image<std::uint32_t> screen = monitor.screen(virtio.id, "shot.ppm");
    EXPECT_EQ(screen.width, 1024);
    EXPECT_EQ(screen.height, 768);
  }
  EXPECT_EQ(crtc_state(virtio.card), before);
  const Image<std::uint32_t> screen = monitor.screen(virtio.id, "console.ppm");
  EXPECT_EQ(screen.width, 1280);
  EXPECT_EQ(screen.height, 720);
}

TEST(KmsModes, AnotherSizeOrRateIsRefusedWithTheModesThereAre) {
  const std::string before = crtc_state(virtio.card);
  const std::string size = refusal([] { KmsDisplay("kms", 912, 1140); });
  EXPECT_THAT(size,
              HasSubstr("card0:Virtual-1: has no mode of the projector's 912x1140 pixels; its modes: "));
  EXPECT_THAT(size, HasSubstr("1280x720@"));
  EXPECT_THAT(size, HasSubstr("1024x768@"));
  std::printf("%s\n", size.c_str());
  EXPECT_THAT(refusal([] { KmsDisplay("kms@17", 1280, 720); }), HasSubstr("1280x720 pixels at 17 Hz"));
  EXPECT_EQ(crtc_state(virtio.card), before);
}

TEST(KmsConnectors, OneThatIsNotConnectedIsRefused) {
  EXPECT_THAT(refusal([] { KmsDisplay("kms:/dev/dri/card0:Virtual-2", 1280, 720); }),
              HasSubstr("Virtual-2 is not there or not connected (its connectors: Virtual-1 connected, "
                        "Virtual-2 not connected)"));
}

TEST(KmsConnectors, AreListed) {
  std::string all;
  for (const DisplayChoice& choice : list_displays()) all += choice.name + ": " + choice.facts + "\n";
  std::printf("%s", all.c_str());
  EXPECT_THAT(all, HasSubstr("kms:/dev/dri/card0:Virtual-1: virtio_gpu"));
  EXPECT_THAT(all, HasSubstr("kms:/dev/dri/card0:Virtual-2: not connected"));
  EXPECT_THAT(all, HasSubstr("kms:/dev/dri/card1:"));
}

// A desktop, here: another process that is the card's master.
TEST(KmsMaster, AnotherProgramsIsRespected) {
  int ready[2], stop[2];
  ASSERT_EQ(::pipe(ready) + ::pipe(stop), 0);
  const pid_t other = ::fork();
  if (other == 0) {
    ::close(stop[1]);
    const auto card = KmsCard::open(virtio.card);
    card->become_master();
    char byte = 'x';
    (void)!::write(ready[1], &byte, 1);
    (void)!::read(stop[0], &byte, 1);  // until the test closes it
    ::_exit(0);
  }
  char byte = 0;
  ASSERT_EQ(::read(ready[0], &byte, 1), 1);
  const std::string said = refusal([] { KmsDisplay("kms:/dev/dri/card0", 1280, 720); });
  for (const int fd : {stop[0], stop[1], ready[0], ready[1]}) ::close(fd);
  ::waitpid(other, nullptr, 0);
  EXPECT_THAT(said, HasSubstr("another program holds this card"));
  EXPECT_THAT(said, HasSubstr("text console"));
  EXPECT_NO_THROW(KmsDisplay("kms:/dev/dri/card0", 1280, 720)) << "free again";
}

TEST(KmsMaster, AUserWithoutTheRightIsToldTheGroup) {
  ::chmod(virtio.card, 0660);
  ASSERT_EQ(::seteuid(65534), 0);
  const std::string said = refusal([] { KmsDisplay("kms:/dev/dri/card0", 1280, 720); });
  ASSERT_EQ(::seteuid(0), 0);
  EXPECT_THAT(said,
              HasSubstr("/dev/dri/card0: you may not open this graphics card; add your user to the group"));
}

// The card is taken from its driver and does not come back: for a run of its own (guest_kms.sh).
TEST(KmsUnplugged, TheCardIsGone) {
  KmsDisplay display("kms:/dev/dri/card1", 1280, 720);
  const ImageF white(1280, 720, 1.0F);
  display.show(even_field(1, "white"), white);
  const std::string device = std::filesystem::read_symlink("/sys/class/drm/card1/device").filename().string();
  std::ofstream("/sys/class/drm/card1/device/driver/unbind") << device;
  for (const auto& call : {std::function<void()>([&] { display.check(); }),
                           std::function<void()>([&] { display.show(even_field(1, "white"), white); })})
    try {
      call();
      ADD_FAILURE() << "no fault";
    } catch (const DeviceFault& fault) {
      EXPECT_EQ(fault.kind(), DeviceFault::Kind::gone) << fault.what();
      std::printf("%s\n", fault.what());
    }
}

}  // namespace
}  // namespace fringetwin::testing::kms_test
