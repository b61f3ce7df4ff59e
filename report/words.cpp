// SPDX-License-Identifier: Apache-2.0
#include "report/words.hpp"

#include <algorithm>
#include <string_view>

#include "report/glossary/terms.hpp"
#include "report/text.hpp"

namespace fringetwin::report {

std::string word_html(const std::string& text) {
  const std::string_view meaning = meaning_of(text);
  if (meaning.empty()) return escape_html(text);
  return "<abbr title=\"" + escape_html(meaning) + "\">" + escape_html(text) + "</abbr>";
}

std::string words_html(const std::string& text) {
  std::string out;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t mark = std::min(text.find_first_of(",:;", begin), text.size()),
                      next = std::min(text.find_first_not_of(",:; ", mark), text.size());
    const std::string part = text.substr(begin, mark - begin);
    out += (part.size() > 1 ? word_html(part) : escape_html(part)) +
           escape_html(std::string_view(text).substr(mark, next - mark));
    begin = next;
  }
  return out;
}

}  // namespace fringetwin::report
