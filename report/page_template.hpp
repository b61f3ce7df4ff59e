// SPDX-License-Identifier: Apache-2.0
// The HTML that every page and figure is filled into (html_page.hpp), as Mustache templates.
#pragma once

namespace fringetwin::report {

/// Mustache template of a page, style sheet included.
extern const char* const kPageTemplate;
/// Mustache template of a figure.
extern const char* const kFigureTemplate;

}  // namespace fringetwin::report
