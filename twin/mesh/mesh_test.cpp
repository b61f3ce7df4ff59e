// SPDX-License-Identifier: Apache-2.0
// Triangle mesh files.
//
// | check                         | tolerance | unit | origin                                          |
// |-------------------------------|-----------|------|-------------------------------------------------|
// | coordinates after loading     | 0         | mm   | float32 in, float32 out (x1000 rounds once)     |
// | vertex normals of a sphere    | 0.02      | rad  | facets of 11 deg: area weights leave 0.013      |
//
// Truth: small files written out by hand; assimp reads what save_mesh_ply writes.
#include "twin/mesh/mesh.hpp"

#include <assimp/scene.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstring>
#include <fstream>
#include <numbers>

#include "tests/support/twin/save_mesh_ply.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::mesh_test {
namespace {
namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;

class MeshFile : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / fmt::format("fringetwin_mesh_{}_{}", info->name(), ::getpid());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }
  static std::string error_of(const fs::path& file) {
    try {
      load_mesh(file, "mm");
    } catch (const UserError& e) {
      EXPECT_EQ(e.code(), ExitCode::input);
      EXPECT_THAT(e.what(), HasSubstr(file.string()));
      return e.what();
    }
    ADD_FAILURE() << "no UserError for " << file;
    return "";
  }
  fs::path folder_;
};

std::string ascii_ply(const std::string& vertices, int n_vertices, const std::string& faces, int n_faces) {
  return fmt::format(
      "ply\nformat ascii 1.0\ncomment c\nelement vertex {}\nproperty float x\nproperty float y\nproperty "
      "float z\n"
      "element face {}\nproperty list uchar int vertex_indices\nend_header\n{}{}",
      n_vertices, n_faces, vertices, faces);
}
const std::string kSquare = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

template <class T>
void put(std::string& out, T value, bool swap) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (swap) std::reverse(raw, raw + sizeof(T));
  out.append(raw, sizeof(T));
}
std::string binary_ply(bool big_endian, const std::vector<float>& coordinates,
                       const std::vector<std::vector<int>>& faces) {
  std::string out = fmt::format(
      "ply\nformat binary_{}_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty "
      "float z\nproperty uchar red\nelement face {}\nproperty uchar flag\nproperty list uchar uint "
      "vertex_index\nend_header\n",
      big_endian ? "big" : "little", coordinates.size() / 3, faces.size());
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    put(out, coordinates[i], big_endian);
    if (i % 3 == 2) out.push_back('\xc8');
  }
  for (const auto& face : faces) {
    out.push_back('\x01');
    out.push_back(static_cast<char>(face.size()));
    for (const int corner : face) put(out, static_cast<std::uint32_t>(corner), big_endian);
  }
  return out;
}

std::string ascii_stl(const std::vector<std::string>& corners, bool end = true) {
  std::string out = "solid part\n";
  for (std::size_t i = 0; i < corners.size(); i += 3)
    out += fmt::format(
        " facet normal 0 0 1\n  outer loop\n   vertex {}\n   vertex {}\n   vertex {}\n  endloop\n endfacet\n",
        corners[i], corners[i + 1], corners[i + 2]);
  return end ? out + "endsolid part\n" : out;
}
std::string binary_stl(const std::vector<float>& coordinates) {
  std::string out(80, ' ');
  put(out, static_cast<std::uint32_t>(coordinates.size() / 9), false);
  for (std::size_t i = 0; i < coordinates.size(); i += 9) {
    for (int k = 0; k < 3; ++k) put(out, k == 2 ? 1.0f : 0.0f, false);
    for (std::size_t k = 0; k < 9; ++k) put(out, coordinates[i + k], false);
    put(out, std::uint16_t{0}, false);
  }
  return out;
}

void expect_unit_square(const Mesh& mesh, float scale = 1.0f) {
  ASSERT_EQ(mesh.vertices_mm.size(), 4u);
  ASSERT_EQ(mesh.triangles.size(), 2u);
  double area = 0.0;
  for (const auto& t : mesh.triangles) {
    const auto v = [&](std::size_t k) { return mesh.vertices_mm[static_cast<std::size_t>(t[k])]; };
    const Eigen::Vector3f n = (v(1) - v(0)).cross(v(2) - v(0));
    EXPECT_GT(n.z(), 0.0f) << "the winding is kept";
    area += 0.5 * static_cast<double>(n.norm());
  }
  EXPECT_EQ(area, static_cast<double>(scale) * static_cast<double>(scale));
}

TEST_F(MeshFile, AsciiPlyTrianglesAndPolygons) {
  expect_unit_square(*load_mesh(write("t.ply", ascii_ply(kSquare, 4, "3 0 1 2\n3 0 2 3\n", 2)), "mm"));
  expect_unit_square(*load_mesh(write("q.ply", ascii_ply(kSquare, 4, "4 0 1 2 3\n", 1)), "mm"));
  expect_unit_square(*load_mesh(write("m.ply", ascii_ply(kSquare, 4, "4 0 1 2 3\n", 1)), "m"), 1000.0f);
}

TEST_F(MeshFile, BinaryPlyOfBothByteOrders) {
  for (const bool big : {false, true})
    expect_unit_square(*load_mesh(
        write("b.ply", binary_ply(big, {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, {{0, 1, 2}, {0, 2, 3}})), "mm"));
}

TEST_F(MeshFile, StlJoinsItsCorners) {
  expect_unit_square(
      *load_mesh(write("a.stl", ascii_stl({"0 0 0", "1 0 0", "1 1 0", "-0 0 0", "1 1 0", "0 1 0"})), "mm"));
  expect_unit_square(
      *load_mesh(write("b.STL", binary_stl({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0})), "mm"));
}

TEST_F(MeshFile, TextFilesMayStartWithAByteOrderMark) {
  const std::string bom = "\xef\xbb\xbf";
  EXPECT_EQ(load_mesh(write("b.stl", bom + ascii_stl({"0 0 0", "1 0 0", "1 1 0"})), "mm")->triangles.size(),
            1u);
  EXPECT_EQ(load_mesh(write("b.ply", bom + ascii_ply(kSquare, 4, "3 0 1 2\n", 1)), "mm")->triangles.size(),
            1u);
  EXPECT_EQ(load_mesh(write("b.obj", bom + "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), "mm")->triangles.size(),
            1u);
}

TEST_F(MeshFile, BinaryStlWhoseHeaderSaysSolid) {
  std::string bytes = binary_stl({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0});
  bytes.replace(0, 14, "solid exported");
  expect_unit_square(*load_mesh(write("s.stl", bytes), "mm"));
}

TEST_F(MeshFile, ObjMergesItsGroupsAndCutsPolygons) {
  const std::string obj =
      "# part\nmtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\n"
      "g one\nf 1//1 2//1 3//1\ng two\nf 1//1 3//1 4//1\n";
  expect_unit_square(*load_mesh(write("g.obj", obj), "mm"));
  expect_unit_square(*load_mesh(write("q.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf -4 -3 -2 -1\n"), "mm"));
}

TEST_F(MeshFile, ContentDecidesForPly) {
  expect_unit_square(*load_mesh(write("t.stl", ascii_ply(kSquare, 4, "4 0 1 2 3\n", 1)), "mm"));
}

TEST_F(MeshFile, DegenerateTrianglesAreDroppedAndCounted) {
  ::testing::internal::CaptureStderr();
  // twice the same corner; three corners on a line; two corners at the same place
  const auto mesh = load_mesh(write("d.ply", ascii_ply("0 0 0\n1 0 0\n1 1 0\n2 0 0\n1 0 0\n", 5,
                                                       "3 0 1 2\n3 0 1 1\n3 0 1 3\n3 1 4 2\n", 4)),
                              "mm");
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), HasSubstr("3 triangles without area left out"));
  EXPECT_EQ(mesh->triangles.size(), 1u);
  EXPECT_EQ(mesh->vertices_mm.size(), 4u);
}

TEST_F(MeshFile, NanAndInfinityNameTheVertex) {
  EXPECT_THAT(error_of(write("n.ply", ascii_ply("0 0 0\n1 nan 0\n1 1 0\n", 3, "3 0 1 2\n", 1))),
              AllOf(HasSubstr("vertex 1 "), HasSubstr("no finite number")));
  EXPECT_THAT(error_of(write("i.ply", ascii_ply("0 0 0\n1 0 0\n1 1 -inf\n", 3, "3 0 1 2\n", 1))),
              HasSubstr("vertex 2 "));
  const float nan = std::nanf("");
  EXPECT_THAT(error_of(write("b.ply", binary_ply(false, {0, 0, 0, 1, 0, 0, 1, nan, 0}, {{0, 1, 2}}))),
              HasSubstr("vertex 2 "));
  // a vertex that no triangle uses counts, too
  EXPECT_THAT(error_of(write("u.ply", ascii_ply("0 0 0\n1 0 0\n1 1 0\nnan 0 0\n", 4, "3 0 1 2\n", 1))),
              HasSubstr("vertex 3 "));
  EXPECT_THAT(error_of(write("n.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n")),
              HasSubstr("no finite number"));
  EXPECT_THAT(error_of(write("n.stl", ascii_stl({"0 0 0", "1 NaN 0", "1 1 0"}))), HasSubstr("corner 1 "));
  EXPECT_THAT(error_of(write("nb.stl", binary_stl({0, 0, 0, 1, 0, 0, 1, nan, 0}))), HasSubstr("corner 2 "));
}

// Finite in the file, infinite as float mm; and where float products of coordinates overflow.
TEST_F(MeshFile, CoordinatesBeyondFloatNameTheVertex) {
  EXPECT_THAT(error_of(write("n.ply", ascii_ply("0 0 0\n1 0 0\n1 1e39 0\n", 3, "3 0 1 2\n", 1))),
              AllOf(HasSubstr("vertex 2 has a coordinate beyond 1e+09 mm: (1, 1e+39, 0)"),
                    HasSubstr("check its unit")));
  EXPECT_THAT(error_of(write("o.obj", "v 0 0 0\nv 1 1e20 0\nv 0 1 0\nf 1 2 3\n")),
              HasSubstr("beyond 1e+09 mm"));
  const fs::path far = write("m.ply", ascii_ply("0 0 0\n1 0 0\n1 2e6 0\n", 3, "3 0 1 2\n", 1));
  EXPECT_EQ(load_mesh(far, "mm")->vertices_mm.size(), 3u);
  EXPECT_THROW(load_mesh(far, "m"), UserError) << "2e6 m is 2e9 mm";
}

TEST_F(MeshFile, TextWhereANumberIsNeeded) {
  EXPECT_THAT(error_of(write("f.ply", ascii_ply("0 0 0\n1 foo 0\n1 1 0\n", 3, "3 0 1 2\n", 1))),
              AllOf(HasSubstr("\"foo\""), HasSubstr("vertex 1 of 3")));
  error_of(write("f.obj", "v 0 0 0\nv 1 foo 0\nv 0 1 0\nf 1 2 3\n"));
  error_of(write("f.stl", ascii_stl({"0 0 0", "1 foo 0", "1 1 0"})));
}

TEST_F(MeshFile, IndicesThatDoNotExist) {
  EXPECT_THAT(error_of(write("o.ply", ascii_ply(kSquare, 4, "3 0 1 2\n3 0 1 4\n", 2))),
              HasSubstr("face 1 of 2 names vertex 4, there are 4"));
  EXPECT_THAT(error_of(write("m.ply", ascii_ply(kSquare, 4, "3 0 1 -1\n", 1))), HasSubstr("vertex -1"));
  error_of(write("o.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"));
}

TEST_F(MeshFile, NoTriangleIsRefused) {
  EXPECT_THAT(error_of(write("e.ply", ascii_ply(kSquare, 4, "", 0))), HasSubstr("has no triangle"));
  EXPECT_THAT(error_of(write("d.ply", ascii_ply(kSquare, 4, "3 0 0 1\n", 1))),
              HasSubstr("has no triangle with an area"));
  EXPECT_THAT(error_of(write("e.stl", "solid a\nendsolid a\n")), HasSubstr("has no triangle"));
  error_of(write("e.obj", "# nothing but a comment, and long enough to be looked at\n"));
}

TEST_F(MeshFile, MissingEmptyAndForeignFiles) {
  EXPECT_THAT(error_of(folder_ / "none.ply"),
              HasSubstr("the mesh cannot be read (No such file or directory); check the name"));
  EXPECT_THAT(error_of(folder_), HasSubstr("is a folder, the mesh must be a file"));
  EXPECT_THAT(error_of(write("empty.ply", "")), HasSubstr("is empty"));
  EXPECT_THAT(error_of(write("x.fbx", "Kaydara FBX Binary")), HasSubstr("PLY, STL and OBJ are read"));
  EXPECT_THAT(error_of(write("x.ply", "not a ply")), HasSubstr("known format"));
  EXPECT_THAT(error_of(write("x.ply", "ply\nformat ascii 2\nrubbish\n")), HasSubstr("bad PLY header line"));
  EXPECT_THAT(error_of(write("x.ply", "ply\nformat morse 1.0\nend_header\n")), HasSubstr("\"morse\""));
}

TEST_F(MeshFile, EveryTruncationOfAPlyIsFound) {
  const std::string last = "3 0 2 3";  // without its last byte "3 0 2 " still lacks a number
  const std::string ascii = ascii_ply(kSquare, 4, "3 0 1 2\n" + last, 2);
  const std::string binary = binary_ply(false, {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, {{0, 1, 2}, {0, 2, 3}});
  for (const std::string& bytes : {ascii, binary})
    for (std::size_t n = 0; n < bytes.size(); ++n) error_of(write("t.ply", bytes.substr(0, n)));
}

TEST_F(MeshFile, AnnouncedCountsAreNotTrusted) {
  EXPECT_THAT(error_of(write("h.ply", ascii_ply(kSquare, 2000000000, "3 0 1 2\n", 1))),
              HasSubstr("is truncated"));
  std::string bytes = binary_ply(false, {0, 0, 0, 1, 0, 0, 1, 1, 0}, {{0, 1, 2}});
  const std::string face = "element face 1\nproperty list uchar int vertex_indices\nend_header\n3 0 1 2\n";
  for (const char* count : {"99999999999", "99999999999999999999", "-1"})
    EXPECT_THAT(
        error_of(write("c.ply", fmt::format("ply\nformat ascii 1.0\nelement vertex {}\n{}", count, face))),
        AnyOf(HasSubstr("has no x, y and z"), HasSubstr("has a bad PLY header line")));
  bytes[bytes.size() - 13] = '\xff';  // 255 corners
  EXPECT_THAT(error_of(write("l.ply", bytes)), HasSubstr("is truncated"));
}

TEST_F(MeshFile, TruncationsOfAnStlAreFound) {
  const std::string binary = binary_stl({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0});
  for (std::size_t n = 0; n < binary.size(); n += 5) error_of(write("b.stl", binary.substr(0, n)));
  const std::string ascii = ascii_stl({"0 0 0", "1 0 0", "1 1 0", "0 0 0", "1 1 0", "0 1 0"}, false);
  for (std::size_t n = 0; n <= ascii.size(); n += 3) error_of(write("a.stl", ascii.substr(0, n)));
}

TEST_F(MeshFile, SavedMeshesComeBack) {
  Mesh mesh;
  mesh.vertices_mm = {{0.1f, 0, 0}, {1, 0, 1e-7f}, {1, 1e6f, 0}, {0, 1, -3}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.vertex_albedo = {0.25f, 0.5f, 0.75f, 1.0f};
  mesh.vertex_normals = compute_vertex_normals(mesh);
  const fs::path file = folder_ / "sub" / "s.ply";
  testing::save_mesh_ply(file, mesh);
  const auto back = load_mesh(file, "mm");
  EXPECT_EQ(back->vertices_mm, mesh.vertices_mm);
  EXPECT_EQ(back->triangles, mesh.triangles);
  EXPECT_EQ(back->vertex_albedo, mesh.vertex_albedo);

  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(file.string(), 0);
  ASSERT_TRUE(scene != nullptr && scene->mNumMeshes == 1) << importer.GetErrorString();
  const aiMesh& foreign = *scene->mMeshes[0];
  ASSERT_EQ(foreign.mNumVertices, 4u);
  ASSERT_EQ(foreign.mNumFaces, 2u);
  for (std::size_t i = 0; i < 4; ++i) {
    const aiVector3D& v = foreign.mVertices[i];
    EXPECT_EQ(Eigen::Vector3f(v.x, v.y, v.z), mesh.vertices_mm[i]);
  }
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(static_cast<int>(foreign.mFaces[i].mIndices[k]), mesh.triangles[i][k]);
}

TEST(MeshNormals, OfASphereAreRadial) {
  Mesh mesh;
  constexpr int rings = 16, sectors = 32;
  for (int i = 0; i <= rings; ++i)
    for (int j = 0; j < sectors; ++j) {
      const double theta = std::numbers::pi * i / rings, phi = 2.0 * std::numbers::pi * j / sectors;
      mesh.vertices_mm.push_back(20.0f * Eigen::Vector3d(std::sin(theta) * std::cos(phi),
                                                         std::sin(theta) * std::sin(phi), std::cos(theta))
                                             .cast<float>());
    }
  const auto index = [](int i, int j) { return i * sectors + j % sectors; };
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < sectors; ++j) {
      mesh.triangles.push_back({index(i, j), index(i + 1, j), index(i + 1, j + 1)});
      mesh.triangles.push_back({index(i, j), index(i + 1, j + 1), index(i, j + 1)});
    }
  const auto normals = compute_vertex_normals(mesh);
  for (int i = 1; i < rings; ++i)  // the poles are rings of separate vertices
    for (int j = 0; j < sectors; ++j) {
      const auto k = static_cast<std::size_t>(index(i, j));
      const Eigen::Vector3f radial = mesh.vertices_mm[k].normalized();
      EXPECT_NEAR(normals[k].norm(), 1.0f, 1e-6f);
      EXPECT_LT(normals[k].cross(radial).norm(), 0.02f + (i == 1 || i == rings - 1 ? 0.08f : 0.0f));
      EXPECT_GT(normals[k].dot(radial), 0.0f);
    }
}

TEST(MeshNormals, OfALonelyVertexAreStillUnit) {
  Mesh mesh;
  mesh.vertices_mm = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {9, 9, 9}};
  mesh.triangles = {{0, 1, 2}};
  EXPECT_EQ(compute_vertex_normals(mesh)[3].norm(), 1.0f);
}

}  // namespace
}  // namespace fringetwin::mesh_test
