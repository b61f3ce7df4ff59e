// SPDX-License-Identifier: Apache-2.0
// Meshes: PLY by our own reader, OBJ and STL through assimp.
#include <cstring>

#include "tests/fuzz/structured.hpp"
#include "tests/fuzz/target.hpp"
#include "twin/mesh/mesh.hpp"

namespace fringetwin::fuzz {
namespace {

void read_mesh_as(const char* name, const std::string& input) {
  compute_vertex_normals(*load_mesh(put_file(name, input), "m"));
}

std::vector<std::string> binary_plys() {
  std::vector<std::string> files;
  const float vertices[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const unsigned char face[] = {3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0};
  for (const char* format : {"binary_little_endian", "binary_big_endian"}) {
    std::string file = std::string("ply\nformat ") + format +
                       " 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                       "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    file.append(reinterpret_cast<const char*>(vertices), sizeof(vertices));
    file.append(reinterpret_cast<const char*>(face), sizeof(face));
    files.push_back(file);
  }
  return files;
}

std::vector<std::string> binary_stls() {
  std::string file(80, 'x');
  file.append("\1\0\0\0", 4);
  const float facet[] = {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0};
  file.append(reinterpret_cast<const char*>(facet), sizeof(facet));
  return {file.append(2, '\0')};
}

}  // namespace

extern const Target ply_target, obj_target, stl_target;

const Target ply_target = {
    "ply",
    [](const std::string& input) { read_mesh_as("input.ply", input); },
    {"good/part.ply", "ply"},
    binary_plys,
    mutate_ply,
    {"element vertex 3\n", "element face 1\n", "property list uchar int vertex_indices\n",
     "property float albedo\n", "property double x\n", "comment c\n", "obj_info o\n", "end_header\n",
     "format ascii 1.0\n", " nan", " -inf", "\r\n"}};

const Target obj_target = {"obj",
                           [](const std::string& input) { read_mesh_as("input.obj", input); },
                           {"good/part.obj", "obj"},
                           nullptr,
                           nullptr,
                           {"mtllib ",
                            "mtllib pipe\n",
                            "mtllib input.obj\n",
                            "usemtl m\n",
                            "newmtl m\n",
                            "map_Kd /dev/zero\n",
                            "f 1 2 3\n",
                            "f 1/1/1 2/2/2 3/3/3\n",
                            "f -1 -2 -3\n",
                            "vt 0 0\n",
                            "vn 0 0 1\n",
                            "g\n",
                            "o\n",
                            "s off\n",
                            "l 1 2\n",
                            "p 1\n",
                            "v 1 2 3 4 5 6\n",
                            "\\\n",
                            "#",
                            "curv 0 1 1\n",
                            "call pipe\n"}};

const Target stl_target = {"stl",
                           [](const std::string& input) { read_mesh_as("input.stl", input); },
                           {"good/part.stl", "stl"},
                           binary_stls,
                           nullptr,
                           {"solid ", "facet normal ", "outer loop", "vertex 0 0 0\n", "endloop",
                            "endfacet\n", "endsolid\n", "COLOR=", "nan"}};

}  // namespace fringetwin::fuzz
