// SPDX-License-Identifier: Apache-2.0
#include "calib/board/corners_vnl.hpp"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "twin/base/errors.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/captures/natural_order.hpp"
#include "twin/image/image_io.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin::calib {
namespace {

constexpr std::size_t kMostColumns = 64;      // rows have four; a comment's words are not kept for ever
constexpr std::size_t kLongestName = 4096;    // of a path in Linux
constexpr std::size_t kMostImages = 1000000;  // hours of video; a calibration has some hundred
/// Weights are at most 1 in mrcal's files; beyond this the solver's sums of squares lose the others.
constexpr double kLargestWeight = 1e6;

const FileUse kCornerFile{.kind = FileKind::table, .what = "corner file", .hint = "check the path"};

std::string at(const std::filesystem::path& file, int line) {
  return fmt::format("{}:{}", file.string(), line);
}

double number(const std::string& text, const std::filesystem::path& file, int line) {
  const std::optional<double> value = parse_number<double>(text);
  if (!value)
    throw UserError(ExitCode::input, at(file, line), quoted_excerpt(text) + " is not a number",
                    "rows are: filename x y level");
  return *value;
}

Corner read_corner(const std::vector<std::string>& f, bool is_weight, const std::filesystem::path& file,
                   int line) {
  Corner c;
  if (f[1] == "-" || f[2] == "-") return c;
  c.q_px = {number(f[1], file, line), number(f[2], file, line)};
  c.weight = 1.0;
  if (f.size() > 3) {
    const double last = f[3] == "-" ? -1.0 : number(f[3], file, line);
    c.weight = last < 0.0 ? -1.0 : is_weight ? last : std::exp2(-last);
  }
  if (!c.q_px.allFinite() || !std::isfinite(c.weight))
    throw UserError(ExitCode::input, at(file, line), "the corner of " + f[0] + " is not finite",
                    "mark a missing corner with - in its last column");
  if (c.weight > kLargestWeight)
    throw UserError(ExitCode::input, at(file, line),
                    fmt::format("the weight of a corner is {}, more than {}", c.weight, kLargestWeight),
                    "weights are relative to each other, mostly 1 and less");
  if (c.weight == 0.0) c.weight = -1.0;
  return c;
}

std::size_t common_prefix(const std::string& a, const std::string& b) {
  return static_cast<std::size_t>(std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first - a.begin());
}

/// Returns the part of each of a device's file names in which they differ.
std::vector<std::string> varying_parts(const std::vector<std::string>& names) {
  std::size_t head = names.front().size(), tail = head, shortest = head;
  const std::string backwards(names.front().rbegin(), names.front().rend());
  for (const std::string& name : names) {
    head = std::min(head, common_prefix(names.front(), name));
    tail = std::min(tail, common_prefix(backwards, std::string(name.rbegin(), name.rend())));
    shortest = std::min(shortest, name.size());
  }
  // A number keeps all its digits: "left10", "left11" vary in 10 and 11, not in 0 and 1.
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  while (head > 0 && is_digit(names.front()[head - 1])) --head;
  while (tail > 0 && is_digit(backwards[tail - 1])) --tail;
  if (head + tail > shortest) tail = shortest - head;
  std::vector<std::string> parts;
  for (const std::string& name : names) parts.push_back(name.substr(head, name.size() - head - tail));
  return parts;
}

/// "007" and "7" are one frame.
std::string frame_key(const std::string& part) {
  if (part.empty() || part.find_first_not_of("0123456789") != std::string::npos) return part;
  const auto first = part.find_first_not_of('0');
  return first == std::string::npos ? "0" : part.substr(first);
}

bool matches(const std::string& glob, const std::string& name) {
  const std::string last = std::filesystem::path(name).filename().string();
  return fnmatch(glob.c_str(), (glob.find('/') == std::string::npos ? last : name).c_str(), 0) == 0;
}

std::string place_of(const ImageCorners& image, const Observations& o) {
  return (image.line > 0 ? at(o.file, image.line) : o.file.string()) + ": " + image.filename;
}

/// Returns the images of each device.
std::vector<std::vector<const ImageCorners*>> by_device(const std::vector<ImageCorners>& images,
                                                        const std::vector<std::string>& globs,
                                                        const Observations& o) {
  std::vector<std::vector<const ImageCorners*>> of_device(globs.size());
  for (const ImageCorners& image : images)
    for (std::size_t d = 0; d < globs.size(); ++d) {
      if (!matches(globs[d], image.filename)) continue;
      for (std::size_t k = 0; k < d; ++k)
        if (matches(globs[k], image.filename))
          throw UserError(ExitCode::usage, place_of(image, o),
                          fmt::format("belongs to \"{}\" and to \"{}\"", globs[k], globs[d]),
                          "give globs that do not overlap");
      of_device[d].push_back(&image);
    }
  for (std::size_t d = 0; d < globs.size(); ++d)
    if (of_device[d].empty())
      throw UserError(ExitCode::input, o.file.string(), fmt::format("\"{}\" matches no image", globs[d]),
                      images.empty() ? "the file has no rows" : "its first image is " + images[0].filename);
  return of_device;
}

}  // namespace

std::vector<ImageCorners> read_corners_vnl(const std::filesystem::path& file, bool has_weights) {
  std::istringstream in(read_whole_text(file, kCornerFile));
  std::vector<ImageCorners> images;
  std::set<std::string> names;
  bool is_weight = has_weights;
  std::string text;
  for (int line = 1; std::getline(in, text); ++line) {
    std::istringstream words(text);
    std::vector<std::string> fields;
    for (std::string word; fields.size() < kMostColumns && words >> word;) fields.push_back(word);
    if (fields.empty() || fields[0].starts_with("##")) continue;
    if (fields[0].starts_with('#')) {
      if (fields.back() == "weight") is_weight = true;
      continue;
    }
    if (fields.size() != 3 && fields.size() != 4)
      throw UserError(ExitCode::input, at(file, line), fmt::format("has {} columns", fields.size()),
                      "rows are: filename x y level");
    if (images.empty() || images.back().filename != fields[0]) {
      if (fields[0].size() > kLongestName)
        throw UserError(ExitCode::input, at(file, line),
                        fmt::format("an image's name has {} characters", fields[0].size()));
      if (images.size() == kMostImages)
        throw UserError(ExitCode::input, at(file, line), fmt::format("more than {} images", kMostImages));
      if (!names.insert(fields[0]).second)
        throw UserError(ExitCode::input, at(file, line),
                        "the rows of " + fields[0] + " are in two places of the file",
                        "write each image once");
      images.push_back({fields[0], {}, line});
    }
    images.back().corners.push_back(read_corner(fields, is_weight, file, line));
  }
  for (ImageCorners& image : images)
    if (image.corners.size() == 1 && !image.corners[0].seen()) image.corners.clear();  // "name - - -"
  return images;
}

void write_corners_vnl(const std::filesystem::path& file, const std::vector<ImageCorners>& images) {
  std::string text = "# filename x y weight\n";
  for (const ImageCorners& image : images) {
    if (image.corners.empty()) text += image.filename + " - - -\n";
    for (const Corner& c : image.corners)
      text += c.seen() ? fmt::format("{} {} {} {}\n", image.filename, c.q_px.x(), c.q_px.y(), c.weight)
                       : fmt::format("{} 0 0 -\n", image.filename);
  }
  write_text_file(file, text);
}

void assign_views(const std::vector<ImageCorners>& images, const std::vector<std::string>& globs,
                  Observations& o) {
  FT_CHECK(globs.size() == o.devices.size(), "one glob per device");
  const auto of_device = by_device(images, globs, o);
  std::vector<std::map<std::string, const ImageCorners*>> of_frame(globs.size());
  std::map<std::string, std::string> name_of;  // key -> first spelling
  for (std::size_t d = 0; d < globs.size(); ++d) {
    std::vector<std::string> names;
    for (const auto* image : of_device[d]) names.push_back(image->filename);
    const std::vector<std::string> parts = varying_parts(names);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const std::string key = frame_key(parts[i]);
      const auto [other, is_new] = of_frame[d].try_emplace(key, of_device[d][i]);
      if (!is_new)
        throw UserError(ExitCode::input, place_of(*of_device[d][i], o),
                        "has the same frame number as " + other->second->filename,
                        "number the images of one device differently");
      name_of.emplace(key, parts[i].empty() ? "0" : parts[i]);
    }
  }
  std::vector<std::string> keys;
  for (const auto& [key, name] : name_of) keys.push_back(key);
  std::ranges::sort(keys, natural_less);
  o.frames.clear();
  o.views.clear();
  for (std::size_t frame = 0; frame < keys.size(); ++frame) {
    o.frames.push_back(name_of[keys[frame]]);
    for (std::size_t d = 0; d < globs.size(); ++d) {
      const auto found = of_frame[d].find(keys[frame]);
      if (found == of_frame[d].end() || found->second->corners.empty()) continue;
      o.views.push_back(
          {static_cast<int>(d), static_cast<int>(frame), found->second->filename, found->second->corners});
    }
  }
  o.sort();
}

}  // namespace fringetwin::calib
