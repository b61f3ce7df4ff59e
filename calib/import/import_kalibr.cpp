// SPDX-License-Identifier: Apache-2.0
// Kalibr camchains: the part of YAML that they use (block mappings two levels deep, sequences of numbers).
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <sstream>

#include "calib/import/imported_rig.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin::calib {
namespace {

constexpr double kMmPerMetre = 1000.0;
constexpr int kMostLines = 10000;  // Kalibr writes about 15 for a camera; each key is kept

struct Entry {
  std::string text;  ///< all of the value, several lines joined by blanks
  int line = 0;
};
struct CameraBlock {
  std::string name;
  int line = 0;
  std::map<std::string, Entry> entries;
};

std::string strip(const std::string& s) {
  const auto first = s.find_first_not_of(" \t\r");
  return first == std::string::npos ? "" : s.substr(first, s.find_last_not_of(" \t\r") - first + 1);
}

/// Position of the colon that ends a key, npos where the line is none.
std::size_t key_end(const std::string& text) {
  if (text.starts_with("- ") || text == "-" || text[0] == '[') return std::string::npos;
  for (std::size_t i = 0; i < text.size(); ++i)
    if (text[i] == ':' && (i + 1 == text.size() || text[i + 1] == ' ')) return i;
  return std::string::npos;
}

std::vector<CameraBlock> read_blocks(const std::filesystem::path& file) {
  std::istringstream in(read_whole_text(file, {.what = "camchain", .hint = "check the path"}));
  std::vector<CameraBlock> blocks;
  Entry* current = nullptr;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    if (++number > kMostLines)
      throw UserError(ExitCode::input, fmt::format("{}:{}", file.string(), number),
                      fmt::format("has more than {} lines, no camchain of Kalibr", kMostLines));
    if (line.find('\t') != std::string::npos)
      throw UserError(ExitCode::input, fmt::format("{}:{}", file.string(), number),
                      "has a tab, which YAML forbids");
    const auto comment = line.find('#');
    if (comment != std::string::npos && (comment == 0 || line[comment - 1] == ' ')) line.resize(comment);
    const std::string text = strip(line);
    if (text.empty() || text == "---" || text.starts_with("%YAML")) continue;
    const std::size_t colon = key_end(text);
    const bool indented = line[0] == ' ';
    if (colon != std::string::npos && !indented) {
      blocks.push_back({text.substr(0, colon), number, {}});
      current = nullptr;
    } else if (colon != std::string::npos && !blocks.empty()) {
      const std::string key = text.substr(0, colon);
      const auto [at, is_new] =
          blocks.back().entries.try_emplace(key, Entry{strip(text.substr(colon + 1)), number});
      if (!is_new)
        throw UserError(ExitCode::input, fmt::format("{}:{}", file.string(), number),
                        quoted_excerpt(key) + " is given twice");
      current = &at->second;
    } else if (current != nullptr) {
      current->text += " " + text;
    } else {
      throw UserError(ExitCode::input, fmt::format("{}:{}", file.string(), number),
                      "is no line of a camchain", "a camchain has cam0:, cam1: ... with keys indented below");
    }
  }
  return blocks;
}

class BlockReader {
 public:
  BlockReader(const std::filesystem::path& file, const CameraBlock& block) : file_(file), block_(block) {}

  const Entry* find(const std::string& key) const {
    const auto at = block_.entries.find(key);
    return at == block_.entries.end() ? nullptr : &at->second;
  }
  const Entry& required(const std::string& key) const {
    const Entry* entry = find(key);
    if (entry == nullptr)
      throw UserError(ExitCode::input, fmt::format("{}:{}", file_.string(), block_.line),
                      fmt::format("{} has no {}", block_.name.substr(0, 40), key));
    return *entry;
  }
  std::string where(const std::string& key) const {
    const Entry* entry = find(key);
    return fmt::format("{}:{}: {}.{}", file_.string(), entry ? entry->line : block_.line,
                       block_.name.substr(0, 40), key);
  }
  std::string word(const std::string& key) const {
    std::string text = required(key).text;
    std::erase_if(text, [](char c) { return c == '\'' || c == '"'; });
    return text;
  }
  std::vector<double> numbers(const std::string& key, std::size_t n) const {
    std::string text = required(key).text;
    for (std::size_t i = 0; i < text.size(); ++i) {
      const bool dash_of_list = text[i] == '-' && (i + 1 == text.size() || text[i + 1] == ' ');
      if (dash_of_list || text[i] == '[' || text[i] == ']' || text[i] == ',') text[i] = ' ';
    }
    std::istringstream words(text);
    std::vector<double> out;
    for (std::string w; words >> w;) {
      const std::optional<double> value = parse_number<double>(w);
      if (!value || !std::isfinite(*value))
        throw UserError(ExitCode::input, where(key), quoted_excerpt(w) + " is not a finite number");
      if (out.push_back(*value); out.size() > n) break;
    }
    if (out.size() > n)
      throw UserError(ExitCode::input, where(key), fmt::format("has more than {} numbers", n));
    if (out.size() != n)
      throw UserError(ExitCode::input, where(key),
                      fmt::format("has {} numbers instead of {}", out.size(), n));
    return out;
  }

 private:
  const std::filesystem::path& file_;
  const CameraBlock& block_;
};

void read_lens(const BlockReader& block, ImportedDevice& out) {
  if (const std::string model = block.word("camera_model"); model != "pinhole")
    throw UserError(ExitCode::input, block.where("camera_model"),
                    quoted_excerpt(model) + " has no equal among the lens models of mrcal",
                    "calibrate with Kalibr's pinhole-radtan");
  out.intrinsics = block.numbers("intrinsics", 4);
  const std::string model = block.find("distortion_model") ? block.word("distortion_model") : "none";
  if (model == "none") {
    out.lensmodel = "LENSMODEL_PINHOLE";
    return;
  }
  if (model != "radtan" && model != "plumb_bob")
    throw UserError(ExitCode::input, block.where("distortion_model"),
                    quoted_excerpt(model) + " has no equal among the lens models of mrcal",
                    "calibrate with Kalibr's pinhole-radtan");
  const std::size_t n = model == "radtan" ? 4 : 5;
  out.lensmodel = n == 4 ? "LENSMODEL_OPENCV4" : "LENSMODEL_OPENCV5";
  for (const double k : block.numbers("distortion_coeffs", n)) out.intrinsics.push_back(k);
}

int whole(double value, const std::string& where) {
  if (value != std::floor(value) || value < 1.0 || value > 65535.0)
    throw UserError(ExitCode::input, where, fmt::format("{:g} is no image side", value));
  return static_cast<int>(value);
}

}  // namespace

std::vector<ImportedDevice> import_kalibr(const std::filesystem::path& file) {
  std::vector<ImportedDevice> out;
  for (const CameraBlock& block : read_blocks(file)) {
    if (!block.name.starts_with("cam")) continue;  // an imu beside the cameras
    const BlockReader reader(file, block);
    ImportedDevice device;
    device.name = block.name;
    device.where = fmt::format("{}:{}: {}", file.string(), block.line, block.name.substr(0, 40));
    read_lens(reader, device);
    const auto size = reader.numbers("resolution", 2);
    device.imagersize_px = {whole(size[0], reader.where("resolution")),
                            whole(size[1], reader.where("resolution"))};
    if (!out.empty()) {
      const auto t = reader.numbers("T_cn_cnm1", 16);
      const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> T(t.data());
      if (T.row(3) != Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0))
        throw UserError(ExitCode::input, reader.where("T_cn_cnm1"), "has another last row than 0 0 0 1");
      const Pose T_this_before{checked_rotation(T.topLeftCorner<3, 3>(), reader.where("T_cn_cnm1")),
                               kMmPerMetre * T.topRightCorner<3, 1>()};
      device.T_device_ref = T_this_before * out.back().T_device_ref;
    }
    out.push_back(std::move(device));
  }
  if (out.empty())
    throw UserError(ExitCode::input, file.string(), "has no cam0, cam1 ...", "is it a Kalibr camchain?");
  return out;
}

}  // namespace fringetwin::calib
