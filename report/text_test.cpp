// SPDX-License-Identifier: Apache-2.0
#include "report/text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <thread>

#include "report/process.hpp"
#include "report/table.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::report::text_test {
namespace {

TEST(Text, EscapesHtml) {
  EXPECT_EQ(escape_html("<a href=\"x\">&'"), "&lt;a href=&quot;x&quot;&gt;&amp;&#39;");
  EXPECT_EQ(escape_html(std::string_view("a\0\033b\nc\xff", 7)), "a??b\nc?");
}

TEST(Text, EscapedHtmlComesBack) {
  for (const std::string text : {"<a href=\"x\">&'", "&lt; &amp;lt;", "plain", ""})
    EXPECT_EQ(unescape_html(escape_html(text)), text);
}

TEST(Text, APathBecomesAnAddress) {
  EXPECT_EQ(url_path("a b/c-1_2.x~/report.html"), "a%20b/c-1_2.x~/report.html");
  EXPECT_EQ(url_path("javascript:x"), "javascript%3Ax");
  EXPECT_EQ(url_path("<\"'&?#%>\xc3\xa9"), "%3C%22%27%26%3F%23%25%3E%C3%A9");
}

TEST(Text, Numbers) {
  EXPECT_EQ(number(0.0), "0");
  EXPECT_EQ(number(1.0 / 3.0, 3), "0.333");
  EXPECT_EQ(number(-1234.56, 4), "−1235");
  EXPECT_EQ(number(2.5e-7, 2), "2.5e-07");
  EXPECT_EQ(number(std::nan("")), "–");
  EXPECT_EQ(fixed(-0.0001, 3), "0.000");
  EXPECT_EQ(signed_fixed(0.0049, 2), "0.00");
  EXPECT_EQ(signed_fixed(0.0051, 2), "+0.01");
  EXPECT_EQ(signed_fixed(-0.3, 1), "−0.3");
  EXPECT_EQ(count(1555200), "1\u202f555\u202f200");
  EXPECT_EQ(count(999), "999");
}

TEST(Text, ValueToTheDigitsOfItsSigma) {
  EXPECT_EQ(with_sigma(17.30291, 0.00412), "17.3029 ± 0.0041");
  EXPECT_EQ(with_sigma(1234.5, 38.0), "1234 ± 38");
  EXPECT_EQ(with_sigma(17.3, std::nan("")), "17.300");
  EXPECT_EQ(with_sigma(std::nan(""), 0.1), "–");
}

TEST(Text, CommandsReadBackInAShell) {
  const std::vector<std::string> argv{"printf", "%s|", "plain", "two words", "it's", "$HOME", ""};
  const auto result = run_process({"sh", "-c", shell_command(argv)}, "");
  ASSERT_TRUE(result.has_value());
  EXPECT_EQ(result->out, "plain|two words|it's|$HOME||");
}

TEST(Process, MovesMoreThanAPipeHolds) {
  const std::string big(3'000'000, 'x');
  const auto result = run_process({"cat"}, big);
  ASSERT_TRUE(result.has_value());
  EXPECT_EQ(result->out, big);
  EXPECT_EQ(result->status, 0);
}

TEST(Process, AProgramThatDoesNotReadIsNoCrash) {
  const auto result = run_process({"sh", "-c", "echo gone >&2; exit 3"}, std::string(3'000'000, 'x'));
  ASSERT_TRUE(result.has_value());
  EXPECT_EQ(result->status, 3);
  EXPECT_EQ(result->err, "gone\n");
}

TEST(Process, AMissingProgramIsReported) {
  const auto result = run_process({"fringetwin-no-such-program"}, "");
  EXPECT_TRUE(!result || result->status == 127);
}

TEST(Process, WhatDoesNotEndIsKilled) {
  using namespace std::chrono_literals;
  for (const char* script : {"exec sleep 10", "exec >&- 2>&-; sleep 10", "sleep 10 & exit 0"}) {
    const auto begin = std::chrono::steady_clock::now();
    const auto result = run_process({"sh", "-c", script}, "", 100ms);
    ASSERT_TRUE(result.has_value()) << script;
    EXPECT_EQ(result->killed_for, "did not end") << script;
    EXPECT_LT(std::chrono::steady_clock::now() - begin, 5s) << script;
  }
  const auto endless = run_process({"yes"}, "");
  ASSERT_TRUE(endless.has_value());
  EXPECT_EQ(endless->killed_for, "writes without end");
}

/// Whether a process runs; one that has ended and that nobody has asked about yet does not.
bool runs(int pid) {
  std::ifstream stat("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  return std::getline(stat, text) && text.find(") Z ") == std::string::npos;
}

TEST(Process, WhatIsKilledTakesItsChildrenAlong) {
  using namespace std::chrono_literals;
  for (const char* script :
       {"sleep 100 & echo $!; wait", "sleep 100 & echo $!", "(sleep 100 & echo $!; wait); true"}) {
    const auto result = run_process({"sh", "-c", script}, "", 300ms);
    ASSERT_TRUE(result.has_value()) << script;
    EXPECT_EQ(result->killed_for, "did not end") << script;
    const int grandchild = std::stoi(result->out);
    for (int i = 0; i < 100 && runs(grandchild); ++i) std::this_thread::sleep_for(10ms);
    EXPECT_FALSE(runs(grandchild)) << script;
    if (runs(grandchild)) ::kill(grandchild, SIGKILL);
  }
}

TEST(Process, ACtrlCAsSoonAsItRunsEndsIt) {
  const auto interrupted = [] {
    install_cancel_handler();
    const auto begin = std::chrono::steady_clock::now();
    try {
      run_process({"sh", "-c", "kill -INT $PPID; exec sleep 100"}, "");
    } catch (const Cancelled&) {
      std::_Exit(std::chrono::steady_clock::now() - begin < std::chrono::seconds(2) ? 0 : 1);
    }
    std::_Exit(2);
  };
  EXPECT_EXIT(interrupted(), ::testing::ExitedWithCode(0), "");
}

TEST(Table, IsReachedByKeyUnderItsName) {
  Table table;
  table.columns = {text_column("object"), {""}, {"rms", "DN"}};
  EXPECT_THAT(table.html(), ::testing::StartsWith("<div class=\"table\" tabindex=\"0\" role=\"group\" "
                                                  "aria-label=\"Table: object, rms\"><table>"));
  table.caption = "a \"b\"";
  table.cards = true;
  EXPECT_THAT(table.html(), ::testing::StartsWith("<div class=\"table cards\" tabindex=\"0\" role=\"group\" "
                                                  "aria-label=\"Table: object, rms\"><table><caption>"));
}

TEST(Table, CarriesUnitsAndEscapes) {
  Table table;
  table.caption = "a & b";
  table.columns = {{"name", "", Align::left}, {"rms", "DN"}};
  table.add_row({"<x>", "1.5"}, "pass");
  table.add_row({"short"});
  const std::string html = table.html();
  EXPECT_NE(html.find("<caption>a &amp; b</caption>"), std::string::npos);
  EXPECT_NE(html.find("<span class=\"unit\">DN</span>"), std::string::npos);
  EXPECT_NE(html.find("<tr class=\"pass\"><td class=\"l\">&lt;x&gt;</td><td class=\"r\">1.5</td>"),
            std::string::npos);
  EXPECT_ANY_THROW(table.add_row({"1", "2", "3"}));
  EXPECT_EQ(html.find("data-head"), std::string::npos);
  table.cards = true;
  table.rows.front().link = "a%20b/\"";
  EXPECT_NE(table.html().find("<td class=\"l\"><a href=\"a%20b/&quot;\">&lt;x&gt;</a></td>"
                              "<td class=\"r\" data-head=\"rms [DN]\">1.5</td>"),
            std::string::npos);
}

}  // namespace
}  // namespace fringetwin::report::text_test
