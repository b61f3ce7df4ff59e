// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/glossary/terms.hpp"
#include "report/html_page.hpp"
#include "report/table.hpp"
#include "report/words.hpp"

namespace fringetwin::report::glossary_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Glossary, AHeadSaysWhatItMeans) {
  Table table;
  table.columns = {text_column("object"), {"σ inflation"}, {"P99 of |d|", "DN"}};
  const std::string html = table.html();
  EXPECT_THAT(html,
              HasSubstr("<abbr title=\"" + std::string(meaning_of("σ inflation")) + "\">σ inflation</abbr>"));
  EXPECT_THAT(html, HasSubstr("P99 of |d|</abbr><span class=\"unit\">DN</span>"));
  EXPECT_THAT(html, HasSubstr("class=\"l\">object</th>"));
  EXPECT_TRUE(meaning_of("object").empty());
}

std::string marked(const std::string& word) {
  return "<abbr title=\"" + std::string(meaning_of(word)) + "\">" + word + "</abbr>";
}

TEST(Glossary, AVerdictSaysWhatItMeans) {
  for (const std::string verdict : {"explained", "not explained", "budget too wide", "not compared"}) {
    ASSERT_FALSE(meaning_of(verdict).empty()) << verdict;
    Table table;
    table.columns = {text_column("where"), {"verdict"}};
    table.add_row({verdict, verdict});  // the first is a name, as far as a table knows
    EXPECT_THAT(table.html(), HasSubstr("<td class=\"l\">" + verdict + "</td><td class=\"r\">" +
                                        marked(verdict) + "</td>"));
    const Page page{.title = "t", .subtitle = "s", .verdict = "phase, gray: " + verdict + "; no limits set"};
    EXPECT_THAT(page.html(), HasSubstr("<div class=\"verdict none\">phase, gray: " + marked(verdict) +
                                       "; no limits set</div>"));
    EXPECT_THAT(page.html(), HasSubstr("<dt>" + verdict + "</dt>"));
  }
}

TEST(Glossary, WordsInASentenceLinksAndCoordinatesStayAsTheyAre) {
  EXPECT_EQ(words_html("it is explained by <noise>, x, z"), "it is explained by &lt;noise&gt;, x, z");
  EXPECT_EQ(words_html("gain;rms ; z:"), marked("gain") + ";" + "rms ; z:");
  EXPECT_EQ(words_html(""), "");
  EXPECT_EQ(words_html("a: b,: ,"), "a: b,: ,");
}

TEST(Glossary, APageListsTheWordsThatItUses) {
  Table table;
  table.columns = {text_column("quantity"), {"χ² of values"}};
  table.add_row({"gray", "1.02"});
  Page page{.title = "t", .subtitle = "s", .summary_html = table.html()};
  const std::string html = page.html();
  EXPECT_THAT(html, HasSubstr("<dt>χ² of values</dt><dd>mean square of the differences"));
  EXPECT_THAT(html, Not(HasSubstr("<dt>R²</dt>")));
  const auto page_of = [](const std::string& cell) {
    return Page{.title = "t", .subtitle = "s", .summary_html = "<td>" + cell + "</td>"}.html();
  };
  EXPECT_THAT(page_of("nothing of it"), Not(HasSubstr("Words on this page")));
  EXPECT_THAT(page_of("explained"), HasSubstr("<dt>explained</dt>"));
  EXPECT_THAT(page_of("from above: x to the right, z up"), Not(HasSubstr("<dt>z</dt>")));  // a coordinate
}

}  // namespace
}  // namespace fringetwin::report::glossary_test
