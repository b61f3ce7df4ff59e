// SPDX-License-Identifier: Apache-2.0
// bench_study [POINTS] [ROUNDS]: what a study costs and how well it uses the cores. POINTS (default 60) noise
// seeds of the paper's sphere (two cameras of 1440 x 1080, 12 patterns, one trace), by one worker and by one
// per core in turn; smallest wall time of ROUNDS (default 2). Efficiency: wall time of one worker / (workers
// x wall time of all). The one worker is held on one core.
#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>

#include "tests/support/twin/child_process.hpp"

namespace {

namespace fs = std::filesystem;
using namespace fringetwin;

double children_cpu_s() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

struct Cost {
  double wall_s = 1e30, cpu_s = 1e30;
};

/// `environment`: before the command.
Cost run(const fs::path& folder, int jobs, const std::string& environment) {
  fs::remove_all(folder / "out");
  const double cpu = children_cpu_s();
  const auto begin = std::chrono::steady_clock::now();
  const int status = std::system(
      fmt::format("{} '{}' -q study '{}' --out '{}' --jobs {} >/dev/null", environment, FRINGETWIN_PROGRAM,
                  (folder / "study.toml").string(), (folder / "out").string(), jobs)
          .c_str());
  if (status != 0) {
    fmt::print(stderr, "the study failed\n");
    std::exit(1);
  }
  return {std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(),
          children_cpu_s() - cpu};
}

void take_smaller(const Cost& cost, Cost* least) {
  least->wall_s = std::min(least->wall_s, cost.wall_s);
  least->cpu_s = std::min(least->cpu_s, cost.cpu_s);
}

}  // namespace

int main(int argc, char** argv) {
  const int points = argc > 1 ? std::atoi(argv[1]) : 60, rounds = argc > 2 ? std::atoi(argv[2]) : 2;
  const testing::ScratchFolder folder;
  folder.write(
      "study.toml",
      fmt::format(
          "schema = \"fringetwin-study/1\"\ntwin = \"{}/datasets/paper-sphere/twin.toml\"\nnoise_seeds = {}\n"
          "[[vary]]\nkeys = [\"camera.left.sensor.read_noise_dn\", \"camera.right.sensor.read_noise_dn\"]\n"
          "values = [1]\n",
          FRINGETWIN_SOURCE_DIR, points));
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  Cost one, all;
  for (int r = 0; r < rounds; ++r) {
    // one worker on one core: what a core does
    take_smaller(run(folder.path(), 1, "taskset -c 0"), &one);
    take_smaller(run(folder.path(), cores, ""), &all);
  }
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  fmt::print("{} points, {} cores\n{:>8} {:>9} {:>9} {:>12} {:>11}\n", points, cores, "workers", "wall s",
             "CPU s", "CPU s/point", "points/min");
  for (const auto& [n, c] : {std::pair{1, one}, {cores, all}})
    fmt::print("{:>8} {:>9.2f} {:>9.2f} {:>12.3f} {:>11.1f}\n", n, c.wall_s, c.cpu_s, c.cpu_s / points,
               60.0 * points / c.wall_s);
  fmt::print("parallel efficiency {:.3f}\nlargest process {:.0f} MiB\n", one.wall_s / (cores * all.wall_s),
             static_cast<double>(usage.ru_maxrss) / 1024.0);
  return 0;
}
