// SPDX-License-Identifier: Apache-2.0
// Collects the drawings of a page while its text is written, makes them all at once and keeps them for files
// of their own.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "report/plot/heat_map.hpp"
#include "report/plot/plot.hpp"

namespace fringetwin::study {

/// A page and its drawings.
struct StudyReport {
  std::string html;
  std::vector<std::pair<std::string, std::string>> figures;  ///< name of a file without ending, its SVG
};

class FigureSheet {
 public:
  /// Returns what stands for the drawing in the text until finish().
  std::string place(const std::string& name, const report::Drawing& drawing);
  template <class Picture>
  std::string place(const std::string& name, const Picture& picture) {
    return place(name, report::drawing(picture));
  }
  /// Returns figures side by side, as wide as the page allows.
  static std::string row(const std::vector<std::string>& placed);

  std::size_t size() const { return drawings_.size(); }

  /// Draws everything into the page. Throws Cancelled.
  StudyReport finish(const std::string& html) const;

 private:
  std::vector<std::string> names_;
  std::vector<report::Drawing> drawings_;
};

}  // namespace fringetwin::study
