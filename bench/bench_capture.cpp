// SPDX-License-Identifier: Apache-2.0
// bench_capture [RUNS]: what recording costs beside the cameras' own time, for frames of 1440 x 1080 px:
// unpacking of each pixel format against a copy of its bytes (of industrial cameras' formats, too, there of
// 2448 x 2048 px), what is done per image, and a whole sequence
// with images written while the next pattern is shown against one after the other. Smallest of RUNS (default
// 3).
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <functional>
#include <random>
#include <thread>

#include "capture/device/pfnc_format.hpp"
#include "capture/device/pfnc_unpack.hpp"
#include "capture/device/pixel_format.hpp"
#include "capture/record/session.hpp"
#include "tests/support/capture/loop_rig.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/sha256.hpp"
#include "twin/image/image_io.hpp"

namespace {

using namespace fringetwin;
using namespace fringetwin::capture;
namespace fs = std::filesystem;

constexpr int kWidth = 1440, kHeight = 1080;
constexpr double kFrameMs = 1000.0 / 60.0;

double best_ms(int runs, const std::function<void()>& what) {
  double best = 1e30;
  for (int i = 0; i < runs; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    what();
    best = std::min(
        best, std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
  }
  return best;
}

Twin large_loop(std::size_t n_cameras, int bit_depth) {
  Twin twin = testing::loop_twin(n_cameras, bit_depth);
  const Lens lens("LENSMODEL_PINHOLE", {2000, 2000, 719.5, 539.5}, {kWidth, kHeight}, "bench");
  for (Camera& camera : twin.cameras) camera.lens = lens;
  twin.projector->lens = lens;
  twin.fringes.directions[0].pitches_px = {13, 14, 15};
  twin.fringes.directions[0].phase_origin_px = {0, 0, 0};
  return twin;
}

ImageU16 fringe_dn(const Twin& twin, int bits) {
  return quantise_levels(pattern_levels(twin.fringes, sequence_patterns(twin.fringes)[0], kWidth, kHeight),
                         bits);
}

void bench_formats(const Twin& twin, int runs) {
  fmt::print("pixel format      unpack ms   copy ms   ratio\n");
  for (const PixelFormatTraits& format : pixel_formats()) {
    if (format.bytes_per_pixel == 0) continue;  // MJPG is the decoder's
    FrameLayout layout;
    layout.format = format.format;
    layout.width = kWidth;
    layout.height = kHeight;
    layout.bytes_per_line = static_cast<std::size_t>(kWidth * format.bytes_per_pixel);
    layout.size_bytes = layout.used_bytes();
    std::vector<std::byte> bytes(layout.size_bytes), copy(layout.size_bytes);
    pack_frame(fringe_dn(twin, format.bit_depth), layout, bytes);
    const double unpack = best_ms(5 * runs, [&] { unpack_frame(bytes, layout); });
    const double plain = best_ms(5 * runs, [&] { std::memcpy(copy.data(), bytes.data(), bytes.size()); });
    fmt::print("{:16} {:10.2f} {:9.2f} {:7.1f}\n", format.name, unpack, plain, unpack / plain);
  }
}

// 5 Mpx, a common industrial sensor.
void bench_pfnc_formats(int runs) {
  fmt::print("\n2448 x 2048 px   unpack ms  CPU ms  one by one ms   copy ms\n");
  for (const PfncFormat& format : pfnc_formats()) {
    if (format.is_mosaic()) continue;  // the same code
    const PfncLayout layout{.format = &format, .width = 2448, .height = 2048};
    std::vector<std::byte> bytes(layout.used_bytes(), std::byte{0}), copy(layout.used_bytes());
    const auto unpack = [&] { unpack_pfnc(bytes, layout); };
    const double fast = best_ms(5 * runs, unpack);
    const std::clock_t begin = std::clock();
    for (int i = 0; i < 5 * runs; ++i) unpack();
    const double cpu = 1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC / (5 * runs);
    unpack_without_vectors(true);
    const double slow = best_ms(5 * runs, unpack);
    unpack_without_vectors(false);
    const double plain = best_ms(5 * runs, [&] { std::memcpy(copy.data(), bytes.data(), bytes.size()); });
    fmt::print("{:16} {:9.2f} {:7.2f} {:14.2f} {:9.2f}\n", format.name, fast, cpu, slow, plain);
  }
}

void bench_image(const Twin& twin, int bits, const fs::path& dir, int runs) {
  ImageU16 dn = fringe_dn(twin, bits);
  std::mt19937 random(1);  // noise in the lowest two bits: what a camera's images compress like
  for (std::uint16_t& value : dn.data) value = static_cast<std::uint16_t>((value & ~3u) | (random() & 3u));
  FrameAverage average(bits, bits);
  average.add(dn, "bench");  // alone it is kept as it is
  const double add = best_ms(5 * runs, [&] { average.add(dn, "bench"); });
  const double store = best_ms(runs, [&] { average.stored(); });
  const ImageF image = average.stored();
  const double write = best_ms(runs, [&] { write_gray_png(dir / "x.png", image, bits <= 8 ? 8 : 16); });
  const double sum = best_ms(runs, [&] { sha256_of_file(dir / "x.png"); });
  fmt::print("{:2} bit: add a frame {:.2f} ms, mean {:.2f}, PNG {:.1f}, checksum {:.1f}\n", bits, add, store,
             write, sum);
}

/// The loop rig, but a frame takes the time it takes.
class PacedDisplay : public PatternDisplay {
 public:
  explicit PacedDisplay(PatternDisplay& display) : display_(display) {}
  DisplayInfo info() const override { return display_.info(); }
  Shown show(const Pattern& pattern, const ImageF& levels) override {
    // a latency of one frame, settling of one and the frame itself
    std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(3.0 * kFrameMs));
    return display_.show(pattern, levels);
  }

 private:
  PatternDisplay& display_;
};

double sequence_ms(const Twin& twin, const fs::path& dir, bool wait) {
  testing::LoopRig rig(twin);
  PacedDisplay display(*rig.display);
  CapturePlan plan;
  plan.latency_ms = 15.0;
  plan.settle_frames = 0;
  const auto begin = std::chrono::steady_clock::now();
  Recording recording(dir, twin, plan, recording_identity(twin, rig.cameras, plan), Existing::overwrite);
  if (wait) recording.write_at_once();
  record_session(twin, rig.cameras, display, plan, recording, {});
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

void bench_sequence(const Twin& twin, const fs::path& dir, int runs) {
  double overlapped = 1e30, serial = 1e30;
  for (int i = 0; i < runs; ++i) {  // in turn, so that both meet the same machine
    overlapped = std::min(overlapped, sequence_ms(twin, dir / "set", false));
    serial = std::min(serial, sequence_ms(twin, dir / "set", true));
  }
  const double n = static_cast<double>(sequence_patterns(twin.fringes).size());
  fmt::print(
      "{} camera(s), {} patterns: {:.0f} ms a pattern ({:.0f} ms of them the cameras'), written one after "
      "the other "
      "{:.0f} ms, ratio {:.2f}\n",
      twin.cameras.size(), n, overlapped / n, 3.0 * kFrameMs, serial / n, serial / overlapped);
}

}  // namespace

int main(int argc, char** argv) {
  const int runs = argc > 1 ? std::max(1, std::atoi(argv[1])) : 3;
  const fs::path dir = fs::temp_directory_path() / fmt::format("fringetwin-bench-capture-{}", ::getpid());
  fs::create_directories(dir);
  set_quiet(true);
  const Twin twin = large_loop(1, 8);
  bench_formats(twin, runs);
  bench_pfnc_formats(runs);
  bench_image(twin, 8, dir, runs);
  bench_image(twin, 12, dir, runs);
  bench_sequence(twin, dir, runs);
  bench_sequence(large_loop(2, 8), dir, runs);
  fs::remove_all(dir);
  return 0;
}
