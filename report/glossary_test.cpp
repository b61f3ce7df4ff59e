// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/glossary/terms.hpp"
#include "report/html_page.hpp"
#include "report/table.hpp"

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
