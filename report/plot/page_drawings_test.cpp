// SPDX-License-Identifier: Apache-2.0
#include "report/plot/page_drawings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "report/plot/plot.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::report::page_drawings_test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

/// A drawing as drawing_svg() writes it.
std::string drawing(const std::string& id) {
  return "<svg role=\"img\" aria-label=\"plot\" viewBox=\"0 0 9 9\"><g id=\"" + id +
         "gnuplot_canvas\"><title>é</title></g></svg>";
}

TEST(PageDrawings, AreFoundInTheirOrderWithNamesOfFiles) {
  const std::string page = "<html><svg class=\"icon\"></svg>" + drawing("gray-left0-") + "<p>text</p>" +
                           drawing("phase-é/..1-") + drawing("gray-left0-") + "</html>";
  const std::vector<PageDrawing> all = drawings_of_page(page);
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[0].name, "gray-left0");
  EXPECT_EQ(all[1].name, "phase-_____1");
  EXPECT_EQ(all[2].name, "gray-left0-3");
  EXPECT_THAT(all[0].svg, StartsWith("<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<svg "));
  EXPECT_THAT(all[0].svg, HasSubstr("fill=\"#ffffff\"/><g id=\"gray-left0-gnuplot_canvas\""));
}

TEST(PageDrawings, OfNoPageAreNone) {
  EXPECT_TRUE(drawings_of_page("").empty());
  EXPECT_TRUE(drawings_of_page("<svg role=\"img\" aria-label=\"map\"></svg>").empty());
  EXPECT_TRUE(drawings_of_page(drawing("cut").substr(0, 40)).empty());
}

TEST(PageDrawings, FilesOfAnEarlierRunGoAndThoseOfOthersStay) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("fringetwin_drawings_" + std::to_string(::getpid()));
  const std::string ours = "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n" + drawing("a-");
  write_drawings(folder, {{"a", ours}, {"b", ours}});
  std::filesystem::rename(folder / "b.svg", folder / "notes.txt");
  std::ofstream(folder / "setup.svg") << "<svg>drawn by hand</svg>";
  write_drawings(folder, {{"c", ours}});
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    names.insert(entry.path().filename().string());
  EXPECT_EQ(names, (std::set<std::string>{"c.svg", "notes.txt", "setup.svg"}));
  EXPECT_EQ(std::filesystem::file_size(folder / "c.svg"), ours.size());
  std::filesystem::remove_all(folder);
}

TEST(PageDrawings, ThoseThatWereNotMadeAreCountedWithTheReasonOfTheFirst) {
  const std::filesystem::path page =
      std::filesystem::temp_directory_path() / ("fringetwin_undrawn_" + std::to_string(::getpid()) + ".html");
  const auto complaint = [&](const std::string& html) -> std::string {
    std::ofstream(page) << "<html>" << html << drawing("a-") << "</html>";
    try {
      check_all_drawn(page);
    } catch (const UserError& error) {
      EXPECT_EQ(error.code(), ExitCode::usage);
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(complaint(""), "");
  EXPECT_EQ(complaint("<p class=\"missing\">Plot left out: plot: there are no data to draw.</p>"), "");
  const std::string undrawn(kUndrawn);
  EXPECT_EQ(complaint(undrawn + "gnuplot: &quot;a &amp;lt;b&quot; &lt;\nx.</p>" + undrawn + "other.</p>"),
            page.string() +
                ": 2 of its drawings could not be made (gnuplot: \"a &lt;b\" <); run the "
                "command that made the page again for them");
  std::filesystem::remove(page);
}

}  // namespace
}  // namespace fringetwin::report::page_drawings_test
