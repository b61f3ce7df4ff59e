// SPDX-License-Identifier: Apache-2.0
#include "twin/base/plain_text.hpp"

#include <gtest/gtest.h>

namespace fringetwin::testing::plain_text_test {
namespace {

using namespace std::string_literals;

TEST(PlainText, LeavesPlainTextAlone) {
  const std::string text = "Größe 3 µm, 日本, \U0001f600, \"C:\\x\"";
  EXPECT_EQ(plain_text(text), text);
  EXPECT_EQ(plain_text(""), "");
}

TEST(PlainText, ShowsNoControlCharacters) {
  EXPECT_EQ(plain_text("a\x1b[31mred\a\0b\x7f"s), "a?[31mred??b?");
  EXPECT_EQ(plain_text("\xc2\x9b"
                       "31m"),
            "?31m");                                                          // CSI as one character
  EXPECT_EQ(plain_text("one\ntwo\r\tthree\xe2\x80\xa8"), "one two  three ");  // U+2028 ends a line
  EXPECT_EQ(plain_text("gpj\xe2\x80\xae.exe"), "gpj?.exe");                   // U+202E: from right to left
  EXPECT_EQ(plain_text("gnuplot\\\0"s), "gnuplot\\?");
}

TEST(PlainText, ShowsNothingThatIsNoUtf8) {
  EXPECT_EQ(plain_text("fr\xe4se"), "fr?se");               // Latin-1
  EXPECT_EQ(plain_text("\xc0\x80"), "??");                  // too long for NUL
  EXPECT_EQ(plain_text("\xed\xa0\x80"), "???");             // a surrogate
  EXPECT_EQ(plain_text("\xf4\x90\x80\x80"), "????");        // above U+10FFFF
  EXPECT_EQ(plain_text("\xf0\x9f\x98"), "???");             // ends early
  EXPECT_EQ(plain_text("\xe2\x82\xc3\xa9"), "??\xc3\xa9");  // a good one behind a broken one
  EXPECT_TRUE(is_utf8("Größe"));
  EXPECT_FALSE(is_utf8("fr\xe4se"));
}

TEST(PlainText, CutsPathsButNotTheirNames) {
  std::string path = "/data";
  for (int i = 0; i < 200; ++i) path += "/folder";
  const std::string sentence = plain_sentence(path + "/twin.toml:12: key must be > 0, is -1; see there");
  EXPECT_LE(sentence.size(), kLongestSentence);
  EXPECT_TRUE(sentence.starts_with("/data/folder/"));
  EXPECT_NE(sentence.find("/folder/twin.toml:12: key must be > 0, is -1; see there"), std::string::npos);
}

TEST(PlainText, CutsSentencesInTheMiddle) {
  std::string words = "begin";
  for (int i = 0; i < 1000; ++i) words += " \xc3\xa4\xc3\xa4";
  const std::string sentence = plain_sentence(words + " end");
  EXPECT_LE(sentence.size(), kLongestSentence);
  EXPECT_GT(sentence.size(), kLongestSentence - 10);
  EXPECT_TRUE(sentence.starts_with("begin "));
  EXPECT_TRUE(sentence.ends_with(" end"));
  EXPECT_NE(sentence.find("..."), std::string::npos);
  EXPECT_TRUE(is_utf8(sentence));
  EXPECT_EQ(plain_sentence("as it is"), "as it is");
}

TEST(PlainText, QuotesTheBeginOfAWord) {
  EXPECT_EQ(quoted_excerpt("x"), "\"x\"");
  EXPECT_EQ(quoted_excerpt(std::string(40, 'x')), "\"" + std::string(40, 'x') + "\"");
  EXPECT_EQ(quoted_excerpt(std::string(41, 'x')), "\"" + std::string(40, 'x') + "...\"");
}

TEST(PlainText, OfLinesKeepsTheirBreaks) {
  EXPECT_EQ(plain_lines("a\033\n\nb\tc\n"), "a?\n\nb c\n");
  EXPECT_EQ(plain_lines(""), "");
}

}  // namespace
}  // namespace fringetwin::testing::plain_text_test
