// SPDX-License-Identifier: Apache-2.0
// Reads the points of a PLY file that the program wrote, by another way than any reader of the program.
#pragma once
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace fringetwin::testing {

struct PlyPoints {
  std::string comment;
  std::size_t n = 0;
  std::vector<std::string> names;                     ///< of the properties, in their order
  std::map<std::string, std::string> type;            ///< by name: double, float, uchar
  std::map<std::string, std::vector<double>> values;  ///< by name
  bool complete = false;                              ///< the file ends with the last point
};

/// Returns the vertices of a binary little-endian PLY that has nothing else.
inline PlyPoints read_ply_points(const std::filesystem::path& file) {
  PlyPoints out;
  std::ifstream in(file, std::ios::binary);
  for (std::string line; std::getline(in, line) && line != "end_header";) {
    std::istringstream words(line);
    std::string keyword, type, name;
    words >> keyword >> type >> name;
    if (keyword == "comment") out.comment = line.substr(8);
    if (keyword == "element") out.n = std::stoul(name);
    if (keyword != "property") continue;
    out.names.push_back(name);
    out.type[name] = type;
  }
  const auto next = [&]<class T>(T value) {
    in.read(reinterpret_cast<char*>(&value), sizeof value);
    return static_cast<double>(value);
  };
  for (std::size_t i = 0; i < out.n; ++i)
    for (const std::string& name : out.names)
      out.values[name].push_back(out.type[name] == "double"  ? next(double{})
                                 : out.type[name] == "float" ? next(float{})
                                                             : next(std::uint8_t{}));
  out.complete = in.good() && in.peek() == std::ifstream::traits_type::eof();
  return out;
}

}  // namespace fringetwin::testing
