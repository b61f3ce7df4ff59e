// SPDX-License-Identifier: Apache-2.0
// Finds the matrices in the text of a file that cv::FileStorage wrote as YAML, XML or JSON. OpenCV's own
// readers are not asked: they overrun their buffers on files that break off or nest too deeply.
#pragma once
#include <filesystem>
#include <functional>
#include <string_view>

namespace fringetwin {

/// Holds one named entry at the top of a file with its own text, where it is a word or number, and the texts
/// of these four keys below it, empty where it has none. They point into the text that was read.
struct StoredEntry {
  std::string_view key = {}, value = {}, rows = {}, cols = {}, dt = {}, data = {};
  bool is_matrix() const { return !dt.empty() && !data.empty(); }
};

/// Calls `visit` for every entry at the top, in order. What lies deeper is passed over, up to 64 levels of
/// brackets or tags. Throws UserError(input) with file and line for text of another form, and where it breaks
/// off.
void visit_opencv_storage(std::string_view text, const std::filesystem::path& file,
                          const std::function<void(const StoredEntry&)>& visit);

}  // namespace fringetwin
