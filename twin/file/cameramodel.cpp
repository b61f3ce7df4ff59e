// SPDX-License-Identifier: Apache-2.0
#include "twin/file/cameramodel.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "twin/base/errors.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/file/python_dict.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin {
namespace {

const FileUse kCameraModel{
    .what = "camera model",
    .hint = "check the path; a .cameramodel is written by mrcal or by fringetwin import"};
/// mrcal writes a line or two; each is kept in memory.
constexpr std::size_t kMostComments = 10000;

std::vector<std::string> leading_comments(const PythonDictParser& parser, std::string_view text) {
  std::vector<std::string> comments;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    const std::size_t start = line.find_first_not_of(" \t");
    if (start != std::string_view::npos) {
      if (line[start] != '#') break;
      if (comments.size() == kMostComments)
        parser.fail(1, "more than " + std::to_string(kMostComments) + " lines of comment before the model");
      comments.emplace_back(line.substr(start + 1));
    }
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return comments;
}

std::array<double, 6> to_rt(const PythonDictParser& parser, const PythonDictEntry& entry) {
  const std::vector<double> numbers = parser.to_numbers(entry);
  if (numbers.size() != 6)
    parser.fail(entry.line,
                "'" + entry.key + "' takes 6 numbers, " + std::to_string(numbers.size()) + " given");
  std::array<double, 6> rt{};
  std::ranges::copy(numbers, rt.begin());
  return rt;
}

std::array<int, 2> to_size(const PythonDictParser& parser, const PythonDictEntry& entry) {
  const std::vector<double> numbers = parser.to_numbers(entry);
  const auto is_size = [](double n) { return n >= 1.0 && n <= 1e6 && n == std::floor(n); };
  if (numbers.size() != 2 || !std::ranges::all_of(numbers, is_size))
    parser.fail(entry.line, "'imagersize' takes two positive whole numbers (width, height)");
  return {static_cast<int>(numbers[0]), static_cast<int>(numbers[1])};
}

/// Python reads "1700" as an int and "-0" as 0; the ".0" keeps type and sign.
std::string model_number(double value) {
  FT_CHECK(std::isfinite(value), "a camera model holds a number that is not finite");
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  std::string text(buffer.data(), end);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

template <class Numbers>
std::string list_text(const Numbers& numbers) {
  std::string text = "[ ";
  for (const double n : numbers) text += model_number(n) + ", ";
  return text + "]";
}

const PythonDictEntry* find(const std::vector<PythonDictEntry>& entries, std::string_view key) {
  const auto found = std::ranges::find_if(entries, [&](const auto& e) { return e.key == key; });
  return found == entries.end() ? nullptr : &*found;
}

const PythonDictEntry& require(const PythonDictParser& parser, const std::vector<PythonDictEntry>& entries,
                               std::string_view key) {
  const PythonDictEntry* entry = find(entries, key);
  if (!entry) parser.fail(1, "the camera model lacks the key '" + std::string(key) + "'");
  return *entry;
}

std::array<double, 6> read_extrinsics(const PythonDictParser& parser,
                                      const std::vector<PythonDictEntry>& entries) {
  const PythonDictEntry* old_name = find(entries, "extrinsics");
  const PythonDictEntry* new_name = find(entries, "rt_cam_ref");  // mrcal >= 2.5 writes both
  if (!new_name) return to_rt(parser, require(parser, entries, "extrinsics"));
  const std::array<double, 6> rt = to_rt(parser, *new_name);
  if (old_name && to_rt(parser, *old_name) != rt)
    parser.fail(new_name->line, "'extrinsics' and 'rt_cam_ref' are the same quantity but differ");
  return rt;
}

/// As it stood in the file, which may have had the other quotes.
std::string quoted_key(const std::string& key) {
  const char quote = key.find('\'') == std::string::npos ? '\'' : '"';
  return quote + key + quote;
}

bool is_interpreted(const std::string& key) {
  return key == "lensmodel" || key == "intrinsics" || key == "extrinsics" || key == "rt_cam_ref" ||
         key == "imagersize";
}

}  // namespace

CameraModelFile read_cameramodel(const std::filesystem::path& file) {
  const std::string text = read_whole_text(file, kCameraModel);
  PythonDictParser parser(file, text);
  const std::vector<PythonDictEntry> entries = parser.parse();
  for (auto e = entries.begin(); e != entries.end(); ++e)
    if (std::any_of(entries.begin(), e, [&](const auto& earlier) { return earlier.key == e->key; }))
      parser.fail(e->line, "the key '" + e->key.substr(0, 40) + "' is given twice");

  CameraModelFile model{.lensmodel = parser.to_string(require(parser, entries, "lensmodel")),
                        .intrinsics = parser.to_numbers(require(parser, entries, "intrinsics")),
                        .rt_cam_ref = read_extrinsics(parser, entries),
                        .imagersize = to_size(parser, require(parser, entries, "imagersize")),
                        .comments = leading_comments(parser, text)};
  for (const PythonDictEntry& e : entries)
    if (!is_interpreted(e.key)) model.extra += quoted_key(e.key) + ": " + std::string(e.value) + ",\n";
  return model;
}

void write_cameramodel(const std::filesystem::path& file, const CameraModelFile& model) {
  std::string text;
  for (std::string comment : model.comments) {
    std::ranges::replace(comment, '\n', ' ');  // of a file's name in it
    text += "#" + comment + "\n";
  }
  text += "{\n";
  text += "    'lensmodel':  '" + model.lensmodel + "',\n\n";
  text += "    # intrinsics are fx,fy,cx,cy,distortion0,distortion1,....\n";
  text += "    'intrinsics': " + list_text(model.intrinsics) + ",\n\n";
  text += "    # extrinsics are rt_cam_ref\n";
  text += "    'extrinsics': " + list_text(model.rt_cam_ref) + ",\n\n";
  text += "    'imagersize': [ " + std::to_string(model.imagersize[0]) + ", " +
          std::to_string(model.imagersize[1]) + " ],\n";
  text += model.extra;
  text += "}\n";
  write_text_file(file, text);
}

}  // namespace fringetwin
