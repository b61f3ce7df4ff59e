// SPDX-License-Identifier: Apache-2.0
// The shipped study of a thousand measurements, a hundred of them: killed at random and resumed it gives the
// table of an unbroken run, from two traces at most, in little memory. The times of all thousand:
// docs/STUDIES.md. tolerance: none (2 GiB is what the study may take on two cores).
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <random>
#include <thread>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/twin/child_process.hpp"

namespace fringetwin::testing::study_thousand_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

TEST(StudyThousand, AHundredOfThemKilledTenTimes) {
  FT_NEED_DEVICE();
  const fs::path shipped = dataset_twin("studies").parent_path();
  std::string text = read_file(shipped / "thousand.toml");
  for (const auto& [from, to] : {std::pair<std::string, std::string>{"noise_seeds = 100", "noise_seeds = 10"},
                                 {"twin = \"", "twin = \"" + shipped.string() + "/"}}) {
    ASSERT_NE(text.find(from), std::string::npos);
    text.replace(text.find(from), from.size(), to);
  }
  const fs::path dir = scratch_folder("study_thousand");
  write_file(dir / "study.toml", text);
  const auto command = [&](const std::string& out) {
    return "'" + std::string(std::getenv("FRINGETWIN_BINARY")) + "' -q study '" +
           (dir / "study.toml").string() + "' --out '" + (dir / out).string() + "' 2>&1";
  };
  const auto begin = std::chrono::steady_clock::now();
  const auto unbroken = testing::run(command("unbroken"));
  const double whole_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_EQ(unbroken.status, 0) << unbroken.output;
  EXPECT_THAT(unbroken.output, HasSubstr("100 measured, 0 failed"));
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  const std::string says = "light traced for ";
  ASSERT_THAT(unbroken.output, HasSubstr(says));
  const int traced = std::atoi(unbroken.output.c_str() + unbroken.output.find(says) + says.size());
  EXPECT_LE(traced, static_cast<int>(cores)) << "one trace for each worker";
  std::mt19937 random(5);
  std::uniform_real_distribution<double> moment(0.04 * whole_s, 0.11 * whole_s);
  int kills = 0;
  for (; kills < 10; ++kills)
    if (testing::run("timeout -s KILL " + std::to_string(moment(random)) + ' ' + command("killed")).status ==
        0)
      break;
  EXPECT_EQ(kills, 10);
  EXPECT_EQ(testing::run(command("killed")).status, 0);
  EXPECT_EQ(read_file(dir / "killed/study.csv"), read_file(dir / "unbroken/study.csv"));
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);  // of the largest process
  const double two_workers_mib = 2.0 * static_cast<double>(usage.ru_maxrss) / 1024.0;
  EXPECT_LT(two_workers_mib, 2048.0);
  std::printf("100 points in %.0f s, killed %d times, two workers take %.0f MiB at most\n", whole_s, kills,
              two_workers_mib);
}

}  // namespace
}  // namespace fringetwin::testing::study_thousand_test
