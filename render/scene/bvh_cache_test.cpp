// SPDX-License-Identifier: Apache-2.0
// No tolerances: a hierarchy from the disk is the built one, bit for bit.
#include "render/scene/bvh_cache.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <fstream>
#include <limits>
#include <span>
#include <vector>

#include "tests/support/freeform.hpp"

namespace fringetwin::render::bvh_cache_test {
namespace {

namespace fs = std::filesystem;

bool same(const Bvh& a, const Bvh& b) {
  return a.nodes.size() == b.nodes.size() && a.order == b.order && a.depth == b.depth &&
         a.box_min == b.box_min && a.box_max == b.box_max &&
         std::memcmp(a.nodes.data(), b.nodes.data(), a.nodes.size() * sizeof(BvhNode)) == 0;
}

// Written anew it would be another file under the old name.
ino_t file_number(const fs::path& file) {
  struct stat status {};
  EXPECT_EQ(::stat(file.c_str(), &status), 0);
  return status.st_ino;
}

class BvhCache : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    mesh_ = new Mesh(testing::make_bumpy_icosphere(4, 35.0, testing::default_bumps()));
    built_ = new Bvh(build_bvh(mesh_->vertices_mm, mesh_->triangles, 32));
  }
  static void TearDownTestSuite() {
    delete mesh_;
    delete built_;
  }
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / fmt::format("fringetwin_bvh_{}_{}", info->name(), ::getpid());
  }
  void TearDown() override { fs::remove_all(folder_); }

  Bvh get() const { return cached_bvh(mesh_->vertices_mm, mesh_->triangles, 32, folder_ / "new", 1000); }
  std::vector<fs::path> files() const {
    std::vector<fs::path> out;
    for (const auto& entry : fs::directory_iterator(folder_ / "new")) out.push_back(entry.path());
    return out;
  }

  static Mesh* mesh_;
  static Bvh* built_;
  fs::path folder_;
};
Mesh* BvhCache::mesh_ = nullptr;
Bvh* BvhCache::built_ = nullptr;

TEST_F(BvhCache, ReadsWhatItWrote) {
  EXPECT_TRUE(same(get(), *built_));
  ASSERT_EQ(files().size(), 1u);
  const auto written = file_number(files()[0]);
  EXPECT_TRUE(same(get(), *built_));
  EXPECT_EQ(file_number(files()[0]), written) << "built again";
}

TEST_F(BvhCache, SmallMeshesAreBuilt) {
  EXPECT_TRUE(same(cached_bvh(mesh_->vertices_mm, mesh_->triangles, 32, folder_ / "new"), *built_));
  EXPECT_FALSE(fs::exists(folder_));
}

TEST_F(BvhCache, AnotherMeshAnotherFile) {
  get();
  std::vector<Eigen::Vector3f> moved = mesh_->vertices_mm;
  moved.back().x() += 1e-3F;
  const Bvh other = cached_bvh(moved, mesh_->triangles, 32, folder_ / "new", 1000);
  EXPECT_EQ(files().size(), 2u);
  EXPECT_TRUE(same(other, build_bvh(moved, mesh_->triangles, 32)));
}

TEST_F(BvhCache, DamagedFilesAreReplaced) {
  get();
  const fs::path file = files().at(0);
  const auto size = fs::file_size(file);
  const auto damage = [&](std::uintmax_t at) {
    std::fstream f(file, std::ios::in | std::ios::out | std::ios::binary);
    f.seekg(static_cast<std::streamoff>(at));
    const int c = f.get();
    f.seekp(static_cast<std::streamoff>(at));
    f.put(static_cast<char>(c ^ 0x40));
  };
  for (const std::uintmax_t at :
       {std::uintmax_t{3}, std::uintmax_t{17}, std::uintmax_t{33}, std::uintmax_t{44}, size / 2, size - 1}) {
    damage(at);
    EXPECT_TRUE(same(get(), *built_)) << "byte " << at;
  }
  fs::resize_file(file, size / 3);
  EXPECT_TRUE(same(get(), *built_)) << "truncated";
  fs::resize_file(file, 0);
  EXPECT_TRUE(same(get(), *built_)) << "empty";
  EXPECT_EQ(fs::file_size(file), size);
}

// With a right checksum: what a traversal would not survive is built anew.
TEST_F(BvhCache, WhatSomebodyElseKeptIsMadeAnew) {
  get();
  const std::string name = files().at(0).stem();
  const std::vector<std::uint8_t> good = *read_cached(folder_ / "new", name);
  constexpr std::size_t kHead = 56, kLeft = 12, kNode = sizeof(BvhNode);
  const std::size_t order = good.size() - 4 * mesh_->triangles.size();
  struct Forged {
    std::size_t at;
    std::int32_t value;
  };
  for (const Forged& f :
       {Forged{kHead + kLeft, 0}, Forged{kHead + kNode + kLeft, 1}, Forged{kHead + kLeft, 1 << 30},
        Forged{kHead + kLeft, -(1 << 30)}, Forged{kHead + kLeft, std::numeric_limits<std::int32_t>::min()},
        Forged{order, static_cast<std::int32_t>(mesh_->triangles.size())}}) {
    std::vector<std::uint8_t> forged = good;
    std::memcpy(forged.data() + f.at, &f.value, sizeof f.value);
    write_cached(folder_ / "new", name, {std::as_bytes(std::span(forged))});
    EXPECT_TRUE(same(get(), *built_)) << f.at << " " << f.value;
    EXPECT_EQ(*read_cached(folder_ / "new", name), good) << "the file is mended";
  }
  std::vector<std::uint8_t> chain = good;  // deeper than the stack of a traversal
  for (std::int32_t i = 0; i < 40; ++i) {
    const std::int32_t next = i + 1;
    std::memcpy(chain.data() + kHead + i * kNode + kLeft, &next, sizeof next);
  }
  write_cached(folder_ / "new", name, {std::as_bytes(std::span(chain))});
  EXPECT_TRUE(same(get(), *built_));
}

TEST_F(BvhCache, WorksWithoutAFolder) {
  fs::create_directories(folder_);
  std::ofstream(folder_ / "file") << "no folder";
  EXPECT_TRUE(
      same(cached_bvh(mesh_->vertices_mm, mesh_->triangles, 32, folder_ / "file" / "under", 1000), *built_));
  EXPECT_TRUE(same(cached_bvh(mesh_->vertices_mm, mesh_->triangles, 32, {}, 1000), *built_));
}

// Each writes its own bytes under the one name while the other reads: a reader gets the one or the other,
// whole.
TEST(DiskCache, TwoProcessesUnderOneName) {
  const fs::path folder = fs::temp_directory_path() / fmt::format("fringetwin_two_processes_{}", ::getpid());
  const auto bytes_of = [](int process) {
    return std::vector<std::uint8_t>(process == 0 ? 300000 : 200001, static_cast<std::uint8_t>(process + 1));
  };
  const auto write_and_read = [&](int process) {
    int wrong = 0;
    for (int i = 0; i < 100; ++i) {
      const std::vector<std::uint8_t> bytes = bytes_of(process);
      write_cached(folder, "shared", {std::as_bytes(std::span(bytes))});
      const auto got = read_cached(folder, "shared");
      wrong += got && (*got == bytes_of(0) || *got == bytes_of(1)) ? 0 : 1;
    }
    return wrong;
  };
  std::array<pid_t, 2> children{};
  for (int process = 0; process < 2; ++process) {
    children[static_cast<std::size_t>(process)] = ::fork();
    if (children[static_cast<std::size_t>(process)] == 0) ::_exit(write_and_read(process));
  }
  for (const pid_t child : children) {
    int status = -1;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 0) << "damaged or missing";
  }
  std::vector<fs::path> left;
  for (const auto& entry : fs::directory_iterator(folder)) left.push_back(entry.path().filename());
  EXPECT_EQ(left, std::vector<fs::path>{"shared.cache"});  // no temporary file
  fs::remove_all(folder);
}

}  // namespace
}  // namespace fringetwin::render::bvh_cache_test
