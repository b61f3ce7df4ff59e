// SPDX-License-Identifier: Apache-2.0
// Mesh files of strangers: each wrong in its own way, each refused in one sentence that names it, or read as
// what it says; none opens another file, none is read without end.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <Eigen/Geometry>
#include <cmath>
#include <csignal>
#include <ctime>

#include "tests/support/twin/child_process.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/mesh/mesh.hpp"
#include "twin/mesh/mesh_file.hpp"
#include "twin/mesh/most_triangles.hpp"

namespace fringetwin::testing::mesh_refusal_test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Lt;
using ::testing::SizeIs;

class MeshOfAStranger : public ::testing::Test {
 protected:
  static std::string sentence_of(const fs::path& file) {
    try {
      load_mesh(file, "mm");
    } catch (const UserError& e) {
      EXPECT_EQ(e.code(), ExitCode::input);
      EXPECT_THAT(e.what(), HasSubstr(file.filename().string()));
      EXPECT_THAT(std::string(e.what()), SizeIs(Lt(500u)));
      return e.what();
    }
    ADD_FAILURE() << "no UserError for " << file;
    return "";
  }
  std::string sentence(const std::string& name, const std::string& bytes) const {
    return sentence_of(dir_.write(name, bytes));
  }
  std::size_t triangles(const std::string& name, const std::string& bytes) const {
    return load_mesh(dir_.write(name, bytes), "mm")->triangles.size();
  }
  ScratchFolder dir_;
};

const std::string kXyz = "property float x\nproperty float y\nproperty float z\n";
const std::string kFace = "element face 1\nproperty list uchar int vertex_indices\n";
const std::string kCorners = "0 0 0\n1 0 0\n0 1 0\n";
const std::string kTriangle = "3 0 1 2\n";

std::string ply(const std::string& header, const std::string& body, const std::string& format = "ascii") {
  return "ply\nformat " + format + " 1.0\n" + header + "end_header\n" + body;
}
/// A mesh of one triangle whose vertices have a further property.
std::string ply_with(const std::string& property, const std::string& value) {
  return ply("element vertex 3\n" + kXyz + "property " + property + "\n" + kFace,
             fmt::format("0 0 0 {0}\n1 0 0 {0}\n0 1 0 {0}\n", value) + kTriangle);
}

TEST_F(MeshOfAStranger, PlyOfTwoElementsOfOneName) {
  const std::string vertices = "element vertex 3\n" + kXyz;
  EXPECT_THAT(sentence("a.ply", ply(vertices + kFace + "element vertex 1000\n" + kXyz,
                                    kCorners + "3 0 1 999\n" + kCorners)),
              HasSubstr("has two elements \"vertex\" in its PLY header"));
  EXPECT_THAT(
      sentence("b.ply", ply(vertices + "element vertex 3\n" + kXyz + "property float albedo\n" + kFace,
                            kCorners + "0 0 1 1\n1 0 1 1\n0 1 1 1\n3 0 1 5\n")),
      HasSubstr("has two elements \"vertex\""));
  EXPECT_THAT(sentence("c.ply", ply(vertices + kFace + kFace, kCorners + kTriangle + kTriangle)),
              HasSubstr("has two elements \"face\""));
}

TEST_F(MeshOfAStranger, PlyOfTwoPropertiesOfOneName) {
  EXPECT_THAT(sentence("x.ply", ply_with("float x", "7")), HasSubstr("has two properties \"x\""));
  EXPECT_THAT(sentence("a.ply", ply_with("float albedo\nproperty float albedo", "1 1")),
              HasSubstr("has two properties \"albedo\" in element \"vertex\""));
  EXPECT_EQ(
      triangles("f.ply", ply("element vertex 3\n" + kXyz + kFace + "property list uchar int vertex_index\n",
                             kCorners + "3 0 1 2 3 0 2 1\n")),
      1u)
      << "one list of corners is read, not both";
}

TEST_F(MeshOfAStranger, PlyElementWithoutPropertiesTakesNoTime) {
  EXPECT_EQ(triangles("n.ply", ply("element nothing 9000000000000000000\nelement vertex 3\n" + kXyz + kFace,
                                   kCorners + kTriangle)),
            1u);
  EXPECT_THAT(sentence("v.ply", ply("element vertex 9000000000000000000\n" + kFace, kTriangle)),
              HasSubstr("has no x, y and z"));
  EXPECT_THAT(
      sentence("f.ply", ply("element vertex 3\n" + kXyz + "element face 9000000000000000000\n", kCorners)),
      HasSubstr("has no triangle"));
}

TEST_F(MeshOfAStranger, PlyCountsAreBoundedByTheFile) {
  EXPECT_THAT(sentence("v.ply", ply("element vertex 9\n" + kXyz + kFace, kCorners + kTriangle)),
              HasSubstr("is truncated (it announces 9 of element \"vertex\""));
  EXPECT_THAT(
      sentence("l.ply", ply("element list 9000000000000000000\nproperty list uchar int a\n", kCorners)),
      HasSubstr("announces 9000000000000000000 of element"));
  for (const char* count : {"3x", "-3", "1e9", "0x3", "99999999999999999999", ""})
    EXPECT_THAT(sentence("c.ply", ply(fmt::format("element vertex {}\n", count) + kXyz + kFace, kCorners)),
                HasSubstr("is no count of element \"vertex\""));
}

TEST_F(MeshOfAStranger, PlyListsOfBadLengths) {
  const std::string header =
      "element vertex 3\n" + kXyz + "element face 1\nproperty list float int vertex_indices\n";
  for (const char* size : {"-1", "1.5", "nan"})
    EXPECT_THAT(sentence("s.ply", ply(header, kCorners + size + " 0 1 2\n")),
                HasSubstr(fmt::format("has a bad list length {}", size)));
  for (const char* size : {"4", "inf", "1e30"})
    EXPECT_THAT(sentence("t.ply", ply(header, kCorners + size + " 0 1 2\n")),
                HasSubstr("is truncated (it ends in face 0 of 1)"));
  const std::string binary("\xff\xff\xff\xff\0\0\0\0", 8);
  EXPECT_THAT(sentence("b.ply", ply("element a 1\nproperty list uint char b\n", binary, "binary_big_endian")),
              HasSubstr("is truncated"));
}

TEST_F(MeshOfAStranger, PlyListsWhereNumbersAreNeeded) {
  const std::string faces = kCorners + kTriangle;
  EXPECT_THAT(sentence("x.ply", ply("element vertex 3\nproperty list uchar float x\nproperty float y\n"
                                    "property float z\n" +
                                        kFace,
                                    "1 0 0 0\n1 1 0 0\n1 0 1 0\n" + kTriangle)),
              HasSubstr("has a list where a vertex has its x"));
  EXPECT_THAT(sentence("a.ply", ply_with("list uchar float albedo", "1 1")), HasSubstr("its albedo"));
  EXPECT_THAT(
      sentence("f.ply",
               ply("element vertex 3\n" + kXyz + "element face 1\nproperty int vertex_indices\n", faces)),
      HasSubstr("has no list of vertices"));
}

TEST_F(MeshOfAStranger, PlyAlbedoIsAFactor) {
  for (const char* value : {"nan", "-0.5", "1e38", "inf", "1e300", "1e400", "255"})
    EXPECT_THAT(sentence("a.ply", ply_with("double albedo", value)),
                AllOf(HasSubstr("vertex 0 of 3 has the albedo"), HasSubstr("between 0 and 1")));
  EXPECT_EQ(load_mesh(dir_.write("g.ply", ply_with("double albedo", "0.25")), "mm")->vertex_albedo.at(2),
            0.25F);
}

// A number beyond the range of double was read as 0.
TEST_F(MeshOfAStranger, NumbersBeyondDouble) {
  const std::string header = "element vertex 3\n" + kXyz + kFace;
  EXPECT_THAT(sentence("l.ply", ply(header, "0 0 0\n1e400 0 0\n0 1 0\n" + kTriangle)),
              HasSubstr("vertex 1 has a coordinate that is no finite number"));
  EXPECT_EQ(triangles("s.ply", ply(header, "0 0 1e-400\n1 0 0\n0 1 0\n" + kTriangle)), 1u);
  EXPECT_THAT(sentence("l.obj", "v 0 0 0\nv 1e400 0 0\nv 0 1 0\nf 1 2 3\n"), HasSubstr("vertex 2 has"));
}

TEST_F(MeshOfAStranger, PlyHeaders) {
  EXPECT_THAT(sentence("f.ply", ply("format binary_little_endian 1.0\nelement vertex 3\n" + kXyz, kCorners)),
              HasSubstr("two format lines"));
  EXPECT_THAT(sentence("l.ply", ply("comment " + std::string(2'000'000, 'x') + "\n", "")),
              HasSubstr("has a PLY header of more than 1048576 bytes"));
  EXPECT_THAT(
      sentence("n.ply", ply("element vertex 3\n" + kXyz + kFace + std::string(1 << 20, '\n'), kCorners)),
      HasSubstr("more than 1048576 bytes"));
  const std::string word(10'000, 'x');
  sentence("k.ply", ply(word + "\n", ""));
  sentence("e.ply", ply("element " + word + " many\n", ""));
  sentence("p.ply", ply("element vertex 3\nproperty " + word + " x\n" + kFace, kCorners));
  sentence("t.ply", "ply\nformat " + word + "\n");
  sentence("b.ply", ply("element " + word + " 1\nproperty int a\n", word));
  std::string names = "element vertex 1\n";
  for (int i = 0; i < 40'000; ++i) names += fmt::format("property char {}\n", i);
  EXPECT_THAT(sentence("m.ply", ply(names, std::string(100'000, '1'))), HasSubstr("has no x, y and z"));
}

TEST_F(MeshOfAStranger, BinaryPlyIndicesOfBothByteOrders) {
  const std::string header =
      "element vertex 1\nproperty char x\nproperty char y\nproperty char z\n"
      "element face 1\nproperty list uchar int vertex_indices\n";
  const std::string body("\0\0\0\3\0\0\0\1\0\0\0\0\0\0\0\0", 16);
  EXPECT_THAT(sentence("l.ply", ply(header, body, "binary_little_endian")),
              HasSubstr("names vertex 16777216"));
  EXPECT_THAT(sentence("b.ply", ply(header, body, "binary_big_endian")),
              HasSubstr("names vertex 1, there are 1"));
}

TEST_F(MeshOfAStranger, MoreThanCanBeTraced) {
  RawMesh mesh("many.stl");
  EXPECT_THROW(mesh.expect_vertices(3 * kMostTriangles + 1), UserError);
  mesh.vertices.resize(3);
  mesh.triangles.reserve(kMostTriangles);
  mesh.triangles.resize(kMostTriangles - 1);
  mesh.add_polygon({0, 1, 2});
  EXPECT_THROW(mesh.add_polygon({0, 1, 2}), UserError);
}

// A library read the file as its own material and crashed, or waited for the pipe.
TEST_F(MeshOfAStranger, ObjNeverOpensAnotherFile) {
  const std::string square = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";
  ASSERT_EQ(::mkfifo((dir_.path() / "pipe.mtl").c_str(), 0600), 0);
  for (const std::string material : {"", "pipe.mtl", "m.obj", "/dev/zero", "$$$___magic___$$$.obj"})
    EXPECT_EQ(triangles("m.obj", "mtllib " + material + "\n" + square), 1u);
  EXPECT_THAT(sentence("c.obj", "mtllib a\ndisp   "), HasSubstr("has no triangle"));
}

TEST_F(MeshOfAStranger, ObjLines) {
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  EXPECT_EQ(triangles("c.obj", corners + "f 1 \\\n 2\\\r\n 3"), 1u);
  EXPECT_EQ(triangles("l.obj", "f 1 2 3\n" + corners), 1u) << "of later lines";
  EXPECT_EQ(triangles("#.obj", "v 0 0 0 # 1\nv 1 0 0 #2\nv 0 1 0 1 #\\\nf 1 2 3 # 4 \\\nf 1 3 2\n"), 2u);
  EXPECT_EQ(triangles("w.obj", "v 0 0 0 1\nv 2 0 0 2\nv 0 1 0 0.1 0.2 0.3\nl 1\nf 1/1/1 2//1 3/2\n"), 1u);
  EXPECT_THAT(sentence("w0.obj", "v 0 0 0 0\n" + corners + "f 2 3 4\n"),
              HasSubstr("vertex 1 has a coordinate"));
  EXPECT_EQ(triangles("b.obj", corners + "f 1 2 3\\\r"), 1u) << "the file ends in a backslash";
  EXPECT_THAT(sentence("0.obj", corners + "f 1 2 0\n"), HasSubstr("names vertex 0 in line 4"));
  EXPECT_THAT(sentence("n.obj", corners + "f -1 -2 -4\n"), HasSubstr("names vertex -4 in line 4"));
  EXPECT_THAT(sentence("4.obj", corners + "f 1 2 4\n"),
              HasSubstr("names vertex 4 in its face 1, there are 3"));
  EXPECT_THAT(sentence("o.obj", corners + "f 1 2 4294967297\n"), HasSubstr("names vertex 4294967297"));
  EXPECT_THAT(sentence("p.obj", corners + "f 1 2 99999999999999999999\n"),
              HasSubstr("where a vertex is needed"));
  EXPECT_THAT(sentence("2.obj", "v 0 0\n"), HasSubstr("has 2 numbers where a vertex has 3, in line 1"));
  EXPECT_THAT(sentence("t.obj", corners + "f " + std::string(1000, 'a')),
              HasSubstr("where a vertex is needed"));
  EXPECT_THAT(sentence("e.obj", corners + "f\nf 1\nf 1 2\n"), HasSubstr("has no triangle"));
}

TEST_F(MeshOfAStranger, ObjVerticesWithoutATriangleAreLeftOut) {
  const auto mesh =
      load_mesh(dir_.write("far.obj", "v 9e8 0 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\nf 2 3 4\n"), "mm");
  EXPECT_THAT(mesh->vertices_mm, SizeIs(3u));
}

// A line as long as the reader's buffer was written one byte beyond it.
TEST_F(MeshOfAStranger, ObjLinesOfAnyLength) {
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  EXPECT_EQ(triangles("c.obj", corners + "f 1 2 3\n#" + std::string(1 << 20, 'x')), 1u);
  EXPECT_THAT(sentence("y.obj", std::string(1 << 20, 'x')), HasSubstr("has no triangle"));
  EXPECT_THAT(sentence("z.obj", std::string(1 << 20, '\0')), HasSubstr("a byte 0"));
}

TEST_F(MeshOfAStranger, StlFacetsAndWords) {
  const auto facet = [](const std::string& vertices) {
    return "solid a\nfacet normal 0 0 1\nouter loop\n" + vertices + "endloop\nendfacet\nendsolid a\n";
  };
  const std::string corners = "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n";
  EXPECT_EQ(triangles("g.stl", facet(corners)), 1u);
  EXPECT_EQ(triangles("two.stl", facet(corners) + facet("vertex 0 0 0\nvertex 2 0 0\nvertex 0 2 0\n")), 2u);
  EXPECT_EQ(triangles("n.stl", "solid\nfacet normal -nan(ind) x y outer loop " + corners +
                                   "endloop endfacet endsolid"),
            1u)
      << "normals are not read";
  EXPECT_THAT(sentence("2.stl", facet("vertex 0 0 0\nvertex 1 0 0\n")),
              HasSubstr("has a facet of 2 corners, it ends in line 7"));
  EXPECT_THAT(sentence("4.stl", facet(corners + "vertex 1 1 0\n")), HasSubstr("has a facet of 4 corners"));
  EXPECT_THAT(sentence("w.stl", facet(corners + "vortex 1 1 0\n")), HasSubstr("\"vortex\" in line 7"));
  EXPECT_THAT(sentence("t.stl", facet("vertex 0 0\nvertex 1 0 0\nvertex 0 1 0\n")),
              HasSubstr("has \"vertex\" where a number is needed, in line 5"));
  EXPECT_THAT(sentence("e.stl", facet(corners) + "solid b\n"), HasSubstr("without endsolid"));
  EXPECT_THAT(sentence("l.stl", facet(corners) + "solid b\n" + corners + "endsolid b\n"),
              HasSubstr("behind its last endfacet"));
}

TEST_F(MeshOfAStranger, BinaryStlCountsMatchTheFile) {
  const auto stl = [](const std::string& count, std::size_t facets) {
    return std::string(80, ' ') + count + std::string(50 * facets, '\0');
  };
  EXPECT_THAT(sentence("m.stl", stl("\xff\xff\xff\xff", 1)), HasSubstr("a binary STL of 4294967295 facets"));
  EXPECT_THAT(sentence("l.stl", stl(std::string("\1\0\0\0", 4), 2)), HasSubstr("this file 184"));
  EXPECT_THAT(sentence("0.stl", stl(std::string(4, '\0'), 0)), HasSubstr("has no triangle"));
  EXPECT_THAT(sentence("d.stl", stl(std::string("\1\0\0\0", 4), 1)), HasSubstr("no triangle with an area"));
}

TEST_F(MeshOfAStranger, FilesThatAreNone) {
  const fs::path pipe = dir_.path() / "pipe.ply", large = dir_.write("large.stl", "");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(sentence_of(pipe), HasSubstr("the mesh must be a regular file"));
  EXPECT_THAT(sentence_of("/dev/zero"), HasSubstr("is a pipe or a device"));
  fs::resize_file(large, (std::uintmax_t{8} << 30) + 1);  // sparse: no byte is written
  EXPECT_THAT(sentence_of(large), HasSubstr("at most 8589934592 are read"));
}

TEST_F(MeshOfAStranger, ConcavePolygonsAreCutAlongTheirOutline) {
  // An L, from its corner that bends inwards on; and the same seen from behind.
  const std::string l = "v 1 1 5\nv 1 2 5\nv 0 2 5\nv 0 0 5\nv 2 0 5\nv 2 1 5\n";
  for (const char* face : {"f 1 2 3 4 5 6\n", "f 6 5 4 3 2 1\n", "f 4 5 6 1 2 3\n"}) {
    const auto mesh = load_mesh(dir_.write("l.obj", l + face), "mm");
    double area = 0.0;
    for (const auto& t : mesh->triangles)
      area += 0.5 * std::abs((mesh->vertices_mm[t[1]] - mesh->vertices_mm[t[0]])
                                 .cross(mesh->vertices_mm[t[2]] - mesh->vertices_mm[t[0]])
                                 .z());
    EXPECT_EQ(area, 3.0) << face;
    EXPECT_EQ(mesh->triangles.size(), 4u);
  }
  // What crosses itself or has no numbers ends, too.
  EXPECT_GT(triangles("x.obj", "v 0 0 0\nv 2 2 0\nv 2 0 0\nv 0 2 0\nv -1 1 0\nf 1 2 3 4 5\n"), 0u);
  sentence("n.obj", "v 0 0 0\nv nan 2 0\nv 2 0 0\nv 0 2 0\nf 1 2 3 4\n");
  std::string comb, face = "f";
  for (int i = 0; i < 2001; ++i) {
    comb += fmt::format("v {} {} 0\n", i, i % 2 == 0 ? 1 : 5);
    face += fmt::format(" {}", i + 1);
  }
  EXPECT_THAT(sentence("c.obj", comb + face), HasSubstr("has a concave polygon of 2001 corners"));
}

/// A corner of a band that winds inwards and back, in which many corners are asked about for each ear.
Eigen::Vector3d spiral_corner(int i, int corners) {
  const bool outwards = i < corners / 2;
  const double turn = 0.3 * (outwards ? i : corners - 1 - i), radius = 1.0 + turn + (outwards ? 0.0 : 0.5);
  return {radius * std::cos(turn), radius * std::sin(turn), 0.0};
}

// A bound on each polygon let many of them take hours.
TEST_F(MeshOfAStranger, AllConcavePolygonsTogetherAreBounded) {
  constexpr int kSpiral = 200;
  RawMesh mesh("many.obj");
  std::vector<int> corners(kSpiral);
  for (int i = 0; i < kSpiral; ++i) {
    corners[i] = i;
    mesh.add_vertex(spiral_corner(i, kSpiral));
  }
  mesh.add_polygon(corners);
  EXPECT_THAT(mesh.triangles, SizeIs(kSpiral - 2));
  mesh.corner_tests_left = 100;
  EXPECT_THROW(mesh.add_polygon(corners), UserError);
}

// Files of 4 GiB that hold nothing beyond their first bytes: read whole they would take as much memory.
TEST_F(MeshOfAStranger, WrongHeadersAreRefusedBeforeTheRestIsRead) {
  const std::string vertices = "element vertex 3\n" + kXyz;
  const std::pair<std::string, std::string> cases[] = {
      {"unknown.ply", "ply\nformat asci 1.0\n"},
      {"no_xyz.ply", ply("element vertex 3\nproperty float x\n" + kFace, "")},
      {"announced.ply", ply("element vertex 3000000000\n" + kXyz + kFace, "")},
      {"faces_first.ply", ply(kFace + vertices, "")},
      {"no_list.ply", ply(vertices + "element face 1\nproperty int vertex_indices\n", "")},
      {"count.stl", std::string(80, '\0') + std::string("\3\0\0\0", 4)},
      {"no_facet.stl", "solid x\n"},
      {"what.msh", "ply"}};
  for (const auto& [name, bytes] : cases) {
    const fs::path file = dir_.write(name, bytes);
    fs::resize_file(file, std::uintmax_t{4} << 30);
    const auto begin = std::clock();
    sentence_of(file);
    EXPECT_LT(std::clock() - begin, CLOCKS_PER_SEC / 2) << name;
  }
}

// In a process of its own: a cancelled program stays cancelled.
TEST_F(MeshOfAStranger, ReadingCanBeCancelled) {
  const std::vector<fs::path> files = {
      dir_.write("c.ply", ply("element vertex 3\n" + kXyz + kFace, kCorners + kTriangle)),
      dir_.write("c.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
      dir_.write(
          "c.stl",
          "solid\nfacet outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0\nendloop endfacet endsolid\n")};
  EXPECT_EXIT(
      {
        install_cancel_handler();
        raise(SIGTERM);
        int thrown = 0;
        for (const fs::path& file : files) {
          try {
            load_mesh(file, "mm");
          } catch (const Cancelled&) {
            ++thrown;
          }
        }
        _exit(thrown == 3 ? 0 : 1);
      },
      ::testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace fringetwin::testing::mesh_refusal_test
