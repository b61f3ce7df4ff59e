// SPDX-License-Identifier: Apache-2.0
// Turns sections, figures and warnings into one page: a self-contained HTML file that needs no network, opens
// from disk and prints well.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace fringetwin::report {

/// Returns a figure of a page: its body (tables, maps, plots: HTML) and, as text, the caption, the formula
/// and the exact command that makes it again; the last two may be empty.
std::string figure_html(const std::string& body_html, const std::string& caption,
                        const std::string& formula = "", const std::string& command = "");

struct Section {
  std::string id;     ///< anchor, unique on the page
  std::string title;  ///< text
  std::string body_html;
};

struct Page {
  std::string title, subtitle = {};
  std::string answer = {};   ///< one sentence, first below the title; may be empty
  std::string verdict = {};  ///< the badge's words; empty: none
  /// "pass", "fail", "none" (neutral); empty: the words, where they are one of these.
  std::string verdict_class = {};
  std::string summary_html = {};  ///< first on the page: the verdict table
  std::string note = {};          ///< what the page can and cannot show; printed in a frame; may be empty
  std::vector<std::string> warnings = {};
  std::vector<Section> sections = {};  ///< in order; the table of contents is made of them
  std::string footer_html = {};        ///< provenance
  std::string script = {};             ///< JavaScript at the end of the page; may be empty
  std::string html() const;
};

/// What the head of a page of this program says, as text.
struct PageHead {
  std::string title, answer, verdict;
};
/// Reads it from the first bytes of a file; nothing of a page of others, and of what cannot be read.
std::optional<PageHead> head_of_page(const std::filesystem::path& file);

}  // namespace fringetwin::report
