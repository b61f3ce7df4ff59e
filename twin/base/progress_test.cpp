// SPDX-License-Identifier: Apache-2.0
// tolerance: none, texts and counts are exact.
#include "twin/base/progress.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <string>
#include <thread>
#include <vector>

#include "twin/base/errors.hpp"
#include "twin/base/stopwatch.hpp"

namespace fringetwin::progress_test {
namespace {

using ::testing::HasSubstr;

std::string stderr_of(const std::function<void()>& work) {
  ::testing::internal::CaptureStderr();
  work();
  return ::testing::internal::GetCapturedStderr();
}

/// What `work` shows on a terminal.
std::string terminal_of(const std::function<void()>& work) {
  int master = -1, slave = -1;
  EXPECT_EQ(openpty(&master, &slave, nullptr, nullptr, nullptr), 0);
  const int saved = dup(STDERR_FILENO);
  dup2(slave, STDERR_FILENO);
  work();
  dup2(saved, STDERR_FILENO);
  close(saved);
  close(slave);
  std::string shown;
  char buffer[4096];
  for (ssize_t n; (n = read(master, buffer, sizeof buffer)) > 0;)
    shown.append(buffer, static_cast<std::size_t>(n));
  close(master);
  return shown;
}

TEST(Progress, OneLinePerTenPercentOffTheTerminal) {
  const std::string text = stderr_of([] {
    Progress progress("render left", 1234);
    for (int i = 0; i < 1234; ++i) progress.advance();
  });
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 10);
  EXPECT_THAT(text, HasSubstr("fringetwin: render left 10 %\n"));
  EXPECT_THAT(text, HasSubstr("fringetwin: render left 100 %\n"));
}

TEST(Progress, SaysTheTimeLeftWhenAsked) {
  const std::string text = stderr_of([] {
    Progress progress("study", 10, true);
    for (int i = 0; i < 10; ++i) progress.advance();
  });
  EXPECT_THAT(text, HasSubstr("fringetwin: study 10 %, 0 s left\n"));
  EXPECT_THAT(text, HasSubstr("fringetwin: study 100 %\n"));
  EXPECT_EQ(rough_time(89.4), "89 s");
  EXPECT_EQ(rough_time(90.0), "2 min");
  EXPECT_EQ(rough_time(89.4 * 60), "89 min");
  EXPECT_EQ(rough_time(12000.0), "3 h 20 min");
}

// 60 of 100 pieces were done by an earlier run: it goes on there.
TEST(Progress, GoesOnBehindWhatWasDoneBefore) {
  const std::string text = stderr_of([] {
    Progress progress("study", 100, true, 60);
    for (int i = 0; i < 40; ++i) progress.advance();
  });
  EXPECT_EQ(text,
            "fringetwin: study 70 %, 0 s left\nfringetwin: study 80 %, 0 s left\n"
            "fringetwin: study 90 %, 0 s left\nfringetwin: study 100 %\n");
  EXPECT_EQ(stderr_of([] { Progress progress("study", 10, true, 11); }), "");
}

TEST(Progress, FewLargeStepsSkipLines) {
  const std::string text = stderr_of([] {
    Progress progress("task", 3);
    for (int i = 0; i < 3; ++i) progress.advance();
  });
  EXPECT_EQ(text, "fringetwin: task 30 %\nfringetwin: task 60 %\nfringetwin: task 100 %\n");
}

TEST(Progress, NothingToDoAndTooMuchDoneAreHarmless) {
  EXPECT_EQ(stderr_of([] { Progress progress("task", 0); }), "");
  EXPECT_EQ(stderr_of([] {
              Progress progress("task", 2);
              progress.advance(5);
              progress.advance(5);
            }),
            "fringetwin: task 100 %\n");
}

TEST(Progress, ThreadsTogetherReachOneHundred) {
  const std::string text = stderr_of([] {
    Progress progress("task", 40000);
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t)
      threads.emplace_back([&] {
        for (int i = 0; i < 10000; ++i) progress.tick();
      });
  });
  EXPECT_THAT(text, HasSubstr("task 100 %\n"));
  EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 10);
}

TEST(Progress, BarOnATerminal) {
  const std::string shown = terminal_of([] {
    Progress progress("render", 4);
    progress.advance(2);
    warn("careful");
    progress.advance(2);
  });
  EXPECT_THAT(shown, HasSubstr("\rrender [####################....................]  50 %"));
  EXPECT_THAT(shown, HasSubstr("\r\033[Kfringetwin: warning: careful"));  // not behind the bar
  EXPECT_THAT(shown, HasSubstr("100 %"));
  EXPECT_TRUE(shown.ends_with("\r\033[K"));
}

TEST(Progress, QuietMutesAllButWarnings) {
  set_quiet(true);
  const std::string text = stderr_of([] {
    Progress progress("task", 2);
    progress.advance(2);
    say("hello");
    warn("mind the gap");
  });
  set_quiet(false);
  EXPECT_EQ(text, "fringetwin: warning: mind the gap\n");
  EXPECT_EQ(stderr_of([] { say("hello"); }), "fringetwin: hello\n");
  EXPECT_EQ(stderr_of([] { warn("a\x1b[2Jb\nc"); }), "fringetwin: warning: a?[2Jb c\n");
}

TEST(Progress, MoreIsSaidOnlyWhereItIsAskedFor) {
  EXPECT_EQ(stderr_of([] { say_more("hello"); }), "");
  set_verbose(true);
  EXPECT_EQ(stderr_of([] { say_more("hello"); }), "fringetwin: hello\n");
  StageTimer timer;
  EXPECT_EQ(stderr_of([&] { timer.start("measure"); }), "fringetwin: stage measure\n");
  EXPECT_THAT(stderr_of([&] { timer.stop(); }),
              ::testing::MatchesRegex("fringetwin: stage measure took 0\\.[0-9]+ s\n"));
  set_verbose(false);
}

// Each in a process of its own: a cancelled program stays cancelled.

TEST(CancelDeathTest, InterruptThrowsFromTheNextAdvance) {
  EXPECT_EXIT(
      {
        install_cancel_handler();
        Progress progress("task", 10);
        progress.advance();
        const bool before = cancelled();
        raise(SIGINT);
        bool thrown = false;
        try {
          progress.advance();
        } catch (const Cancelled&) {
          thrown = true;
        }
        const bool tick = progress.tick();
        _exit(!before && thrown && !tick && cancelled() ? 0 : 1);
      },
      ::testing::ExitedWithCode(0), "");
}

TEST(CancelDeathTest, ThrowIfCancelled) {
  EXPECT_EXIT(
      {
        install_cancel_handler();
        throw_if_cancelled();
        raise(SIGINT);
        try {
          throw_if_cancelled();
        } catch (const Cancelled&) {
          _exit(0);
        }
        _exit(1);
      },
      ::testing::ExitedWithCode(0), "");
}

TEST(CancelDeathTest, TheSecondInterruptKills) {
  EXPECT_EXIT(
      {
        install_cancel_handler();
        raise(SIGINT);
        raise(SIGINT);
        _exit(0);
      },
      ::testing::KilledBySignal(SIGINT), "");
}

TEST(Errors, SentenceAndCode) {
  const UserError e(ExitCode::input, "left/0003.png", "is 640x480, the camera is 1440x1080",
                    "export it unscaled");
  EXPECT_STREQ(e.what(), "left/0003.png: is 640x480, the camera is 1440x1080; export it unscaled");
  EXPECT_EQ(e.code(), ExitCode::input);
  EXPECT_STREQ(UserError(ExitCode::usage, "", "no twin given").what(), "no twin given");
}

TEST(Errors, CheckNamesExpressionPlaceAndMessage) {
  try {
    FT_CHECK(1 + 1 == 3, "arithmetic");
    FAIL();
  } catch (const std::logic_error& e) {
    EXPECT_THAT(e.what(), HasSubstr("progress_test.cpp:"));
    EXPECT_THAT(e.what(), HasSubstr("check failed: 1 + 1 == 3: arithmetic"));
  }
}

}  // namespace
}  // namespace fringetwin::progress_test
