// SPDX-License-Identifier: Apache-2.0
#include "report/html_page.hpp"

#include <algorithm>
#include <kainjow/mustache.hpp>

#include "report/glossary/terms.hpp"
#include "report/page_template.hpp"
#include "report/text.hpp"
#include "report/words.hpp"
#include "twin/base/safe_file.hpp"

namespace fringetwin::report {

namespace mustache = kainjow::mustache;

namespace {

constexpr std::size_t kHeadOfPage = 1
                                    << 16;  ///< bytes: the style sheet has 9000, and the answer is a sentence

/// An empty text hides its block in the template.
void set_if(mustache::data& data, const std::string& key, const std::string& text) {
  if (text.empty())
    data.set(key, mustache::data::type::bool_false);
  else
    data.set(key, text);
}

std::string rendered(const char* page, const mustache::data& data) {
  mustache::mustache page_template(page);
  page_template.set_custom_escape(escape_html);
  return page_template.render(data);
}

/// Returns the words of the glossary that occur in this HTML, with their meanings, as a list that opens when
/// clicked; empty where none does.
std::string glossary_html(const std::string& page_html) {
  std::string list;
  for (const auto& [word, meaning] : glossary()) {
    // as a cell, a head or a letter of a formula that stands by itself; a Latin letter may be a coordinate
    const std::string text = escape_html(std::string(word));
    const bool in_text = word.size() > 1;
    const auto occurs = [&](const char* before, const char* after) {
      return page_html.find(before + text + after) != std::string::npos;
    };
    if (occurs(">", "<") || (in_text && (occurs(" ", " ") || occurs(" ", "<"))))
      list += "<dt>" + text + "</dt><dd>" + escape_html(std::string(meaning)) + "</dd>";
  }
  return list.empty() ? ""
                      : "<details class=\"words\"><summary>Words on this page</summary><dl>" + list +
                            "</dl></details>";
}

std::string without_tags(std::string_view html) {
  std::string out;
  for (std::size_t begin = 0; begin < html.size();) {
    const std::size_t tag = std::min(html.find('<', begin), html.size()), end = html.find('>', tag);
    out += html.substr(begin, tag - begin);
    begin = end == std::string_view::npos ? html.size() : end + 1;
  }
  return out;
}

/// Returns the text of the first element that begins with `tag`, whose own end is `end`; empty without one.
std::string text_of_element(std::string_view html, std::string_view tag, std::string_view end) {
  const std::size_t begin = html.find(tag);
  if (begin == std::string_view::npos) return "";
  const std::size_t text = html.find('>', begin), after = html.find(end, begin);
  if (text == std::string_view::npos || after == std::string_view::npos || after < text) return "";
  return unescape_html(without_tags(html.substr(text + 1, after - text - 1)));
}

}  // namespace

std::optional<PageHead> head_of_page(const std::filesystem::path& file) {
  std::string html;
  try {
    std::uintmax_t size = 0;
    html = read_text_start(file, {.what = "page"}, kHeadOfPage, &size);
  } catch (const UserError&) {
    return {};
  }
  const std::size_t begin = html.find("<header>"), end = html.find("</header>");
  const bool ours = html.find("<meta name=\"generator\" content=\"fringetwin\">") < begin;
  if (!ours || begin == std::string::npos || end == std::string::npos || end < begin) return {};
  const std::string_view head = std::string_view(html).substr(begin, end - begin);
  return PageHead{.title = text_of_element(head, "<h1", "</h1>"),
                  .answer = text_of_element(head, "<p class=\"answer\"", "</p>"),
                  .verdict = text_of_element(head, "<div class=\"verdict", "</div>")};
}

std::string figure_html(const std::string& body_html, const std::string& caption, const std::string& formula,
                        const std::string& command) {
  mustache::data data;
  data.set("body", body_html);
  data.set("caption", caption);
  set_if(data, "formula", formula);
  set_if(data, "command", command);
  return rendered(kFigureTemplate, data);
}

std::string Page::html() const {
  mustache::data data;
  data.set("title", title);
  set_if(data, "answer", answer);
  data.set("subtitle", subtitle);
  set_if(data, "verdict", words_html(verdict));
  data.set("verdict_class", !verdict_class.empty()                   ? verdict_class
                            : verdict == "pass" || verdict == "fail" ? verdict
                                                                     : "none");
  data.set("summary", summary_html);
  set_if(data, "note", note);
  mustache::data list{mustache::data::type::list};
  for (const Section& section : sections) {
    mustache::data one;
    one.set("id", section.id);
    one.set("title", section.title);
    one.set("body", section.body_html);
    list << one;
  }
  data.set("sections", list);
  mustache::data texts{mustache::data::type::list};
  for (const std::string& warning : warnings) texts << mustache::data{"text", warning};
  data.set("has_warnings",
           warnings.empty() ? mustache::data::type::bool_false : mustache::data::type::bool_true);
  data.set("warnings", texts);
  std::string content = words_html(verdict) + summary_html;
  for (const Section& section : sections) content += section.body_html;
  data.set("footer", footer_html + glossary_html(content));
  set_if(data, "script", script);
  return rendered(kPageTemplate, data);
}

}  // namespace fringetwin::report
