// SPDX-License-Identifier: Apache-2.0
// bench_sensor [ROUNDS]: noisy images of 1440 x 1080 pixels by the formula pixel after pixel, with the
// library's log and cos, and by render/sensor/sensor.cpp, in turn on one core; smallest time of ROUNDS
// (default 5). Refuses images that are not the same.
#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>

#include "render/base/normal_deviates.hpp"
#include "render/sensor/sensor.hpp"

namespace {

using namespace fringetwin;

ImageF by_formula(const ImageF& light, const Sensor& sensor) {
  ImageF gray(light.width, light.height);
  const double read = sensor.read_noise_dn.value_or(0.0);
  for (std::size_t i = 0; i < light.size(); ++i) {
    const double signal = sensor.gain_dn * static_cast<double>(light.data[i]);
    const double variance = (sensor.electrons_per_dn ? signal / *sensor.electrons_per_dn : 0.0) + read * read;
    double dn = signal + sensor.black_level_dn;
    if (variance > 0.0) dn += std::sqrt(variance) * render::exact_deviate({{1, 0}, 0, 0}, i);
    gray.data[i] = static_cast<float>(std::floor(std::clamp(dn, 0.0, sensor.max_dn()) + 0.5));
  }
  return gray;
}

template <class Make>
double seconds(Make make, ImageF* image) {
  const auto begin = std::chrono::steady_clock::now();
  *image = make();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 5;
  omp_set_num_threads(1);
  ImageF fringes(1440, 1080, 0.0F);  // a third of it lit
  for (std::size_t i = 0; i < fringes.size(); ++i)
    if (i % 1440 < 480)
      fringes.data[i] = static_cast<float>(0.5 + 0.4 * std::sin(0.3 * static_cast<double>(i % 1440)));
  fmt::print("{:28} {:>12} {:>12} {:>8}\n", "sensor", "formula", "blocks", "ratio");
  for (const auto& [name, bits, read, electrons] : {std::tuple("12 bit, 8 DN", 12, 8.0, 0.0),
                                                    {"8 bit, 0.5 DN", 8, 0.5, 0.0},
                                                    {"12 bit, 2 DN and photons", 12, 2.0, 4.0}}) {
    Sensor sensor;
    sensor.bit_depth = bits;
    sensor.gain_dn = std::exp2(bits) - 1.0;
    sensor.read_noise_dn = read;
    if (electrons > 0.0) sensor.electrons_per_dn = electrons;
    double formula_s = 1e30, blocks_s = 1e30;
    for (int round = 0; round < rounds; ++round) {
      ImageF a, b;
      formula_s = std::min(formula_s, seconds([&] { return by_formula(fringes, sensor); }, &a));
      blocks_s = std::min(blocks_s, seconds([&] { return render::expose(fringes, sensor, 1, 0, 0); }, &b));
      if (a.data != b.data) {
        fmt::print(stderr, "the images differ\n");
        return 1;
      }
    }
    const double pixels = static_cast<double>(fringes.size());
    fmt::print("{:28} {:9.1f} ns {:9.1f} ns {:8.1f}\n", name, 1e9 * formula_s / pixels,
               1e9 * blocks_s / pixels, formula_s / blocks_s);
  }
  return 0;
}
