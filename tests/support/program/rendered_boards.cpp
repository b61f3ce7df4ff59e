// SPDX-License-Identifier: Apache-2.0
#include "tests/support/program/rendered_boards.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tests/support/program/small_twin.hpp"
#include "twin/image/image_io.hpp"
#include "twin/lens/pose.hpp"

namespace fringetwin::testing {

namespace fs = std::filesystem;

namespace {

constexpr float kBlack = 30.0F, kWhite = 255.0F;

/// Dark circles around the corners of squares of `n` texels; a texel by the share that is inside.
float circle_texel(int x, int y, int n, int columns, int rows, double radius_squares) {
  if (x <= 1.5 * n || y <= 1.5 * n || x >= (columns - 1.5) * n || y >= (rows - 1.5) * n) return kWhite;
  const auto from_corner = [n](int texel) {  // in squares
    const double at = (texel + 0.5) / n;
    return at - std::round(at);
  };
  const double inside = (radius_squares - std::hypot(from_corner(x), from_corner(y))) * n + 0.5;
  return static_cast<float>(static_cast<double>(kWhite) -
                            static_cast<double>(kWhite - kBlack) * std::clamp(inside, 0.0, 1.0));
}

/// Squares, a white border of one square.
float square_texel(int x, int y, int n, int columns, int rows) {
  const int c = x / n, r = y / n;
  const bool border = c == 0 || r == 0 || c == columns - 1 || r == rows - 1;
  return border || (c + r) % 2 == 1 ? kWhite : kBlack;
}

/// The first inner corner lies 2 squares from the top left. (Circles of 16 texels a square bias the rig by up
/// to 2.7 sigma.)
void write_board_image(const fs::path& file, const calib::Board& board, double circle_diameter_mm) {
  const int texels = circle_diameter_mm > 0.0 ? 64 : 16;  // per square
  const int columns = board.width_n + 3, rows = board.height_n + 3;
  ImageF image(columns * texels, rows * texels);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      image(x, y) = circle_diameter_mm > 0.0 ? circle_texel(x, y, texels, columns, rows,
                                                            0.5 * circle_diameter_mm / board.spacing_mm)
                                             : square_texel(x, y, texels, columns, rows);
  write_gray_png(file, image, 8);
}

std::string comma_list(const Eigen::Vector3d& v) { return fmt::format("{}, {}, {}", v.x(), v.y(), v.z()); }

}  // namespace

std::vector<RenderedBoards::Device> RenderedBoards::devices() const {
  const double k = 1.0 / reduction;
  const std::array<int, 2> size{1440 / reduction, 1080 / reduction};
  const auto rt = [](std::array<double, 6> v) { return RotTrans(RotTrans::Map(v.data())); };
  RotTrans right = rt({-0.0086, 0.7078, 0.0058, -189.5009, -1.1664, 66.0589});
  if (right_upside_down) {
    // Not by 180 degrees, where a rotation vector may be either of two.
    const Eigen::AngleAxisd nearly_half_a_turn(3.0, Eigen::Vector3d::UnitZ());
    const Pose about_its_axis{nearly_half_a_turn.toRotationMatrix(), Eigen::Vector3d::Zero()};
    right = rt_from_pose(about_its_axis * pose_from_rt(right));
  }
  return {
      {"left",
       size,
       {2359.6 * k, 2359.0 * k, 734.5 * k, 578.5 * k, -0.1251, 0.1620, 0.0003, -0.0004},
       rt({0, 0, 0, 0, 0, 0})},
      {"right", size, {2360.6 * k, 2359.8 * k, 736.9 * k, 580.9 * k, -0.1170, 0.1249, 0.0, -0.0002}, right},
      {"projector",
       {1280, 720},
       {1700.15, 1701.22, 627.73, 406.54, 0.1328, -0.3361, -0.0006, -0.0001},
       rt({-0.0099, 0.3754, 0.0276, -94.5914, -0.1889, 12.4706})}};
}

Pose RenderedBoards::T_world_board(int i) const {
  // Spread over tilt, roll and distance; turned by 0.35 rad towards the middle of the devices, and above the
  // first one's axis, where the projector's field is.
  constexpr std::array<double, 4> kTilts{-0.55, 0.1, 0.5, -0.2};
  const double tx = kTilts[static_cast<std::size_t>(i % 4)],
               ty = -0.35 + kTilts[static_cast<std::size_t>((i / 2 + 1) % 4)] * 0.8,
               roll = 0.25 * std::sin(1.7 * i), z = 268.0 + 42.0 * std::fmod(0.618 * i, 1.0);
  const Eigen::Matrix3d R =
      (Eigen::AngleAxisd(tx, Eigen::Vector3d::UnitX()) * Eigen::AngleAxisd(ty, Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()))
          .toRotationMatrix();
  const Eigen::Vector3d middle(6.0 * std::cos(2.1 * i), 5.0 * std::sin(1.3 * i) - 6.0, z);
  return {R, middle - R * Eigen::Vector3d(0.5 * board.width_mm(), 0.5 * board.height_mm(), 0.0)};
}

std::string RenderedBoards::devices_toml(bool rough) const {
  std::string toml;
  for (const Device& d : devices()) {
    const double f = std::round(1.15 * d.intrinsics[0] / 50.0) * 50.0;
    const std::string intrinsics =
        rough ? fmt::format("{0}, {0}, {1}, {2}", f, 0.5 * (d.size[0] - 1), 0.5 * (d.size[1] - 1))
              : fmt::format("{}", fmt::join(d.intrinsics, ", "));
    const bool is_projector = d.name == "projector";
    toml += fmt::format(
        "{}lensmodel = \"{}\"\nimagersize = [{}, {}]\nintrinsics = [{}]\nrt_cam_world = [{}]\n",
        is_projector ? "[projector]\nintensity = 40.0\n" : "[[camera]]\nname = \"" + d.name + "\"\n",
        rough ? "LENSMODEL_PINHOLE" : "LENSMODEL_OPENCV4", d.size[0], d.size[1], intrinsics,
        fmt::join(d.rt_cam_world.data(), d.rt_cam_world.data() + 6, ", "));
    if (!is_projector)
      toml += "[camera.sensor]\ngain_dn = 18.0\nelectrons_per_dn = 40.2\nread_noise_dn = 0.3\n";
  }
  return "schema = \"fringetwin-twin/1\"\nname = \"board\"\ncameramodel_unit = \"mm\"\n" + toml +
         "[fringes]\ndirections = [\"x\", \"y\"]\npitches_px = [19, 20, 21]\nsteps = 4\nunwrap = "
         "\"heterodyne\"\n"
         "[measure]\nmin_modulation_dn = 4\n";
}

std::vector<std::string> RenderedBoards::render(const fs::path& dir) const {
  write_board_image(dir / "board.png", board, circle_diameter_mm);
  write_file(dir / "rough.toml", devices_toml(true));
  std::vector<std::string> folders;
  for (int i = 0; i < n_boards; ++i) {
    const Pose T = T_world_board(i);
    const Eigen::Vector3d middle = T * Eigen::Vector3d(0.5 * board.width_mm(), 0.5 * board.height_mm(), 0.0);
    const std::string object = fmt::format(
        "[[object]]\nname = \"board\"\nshape = \"plane\"\npoint_mm = [{}]\nnormal = [{}]\nu_axis = [{}]\n"
        "size_mm = [{}, {}]\nalbedo_map = \"board.png\"\n[object.material]\ndiffuse = 0.8\n",
        comma_list(middle), comma_list(T.rotation.col(2)), comma_list(T.rotation.col(0)),
        board.spacing_mm * (board.width_n + 3), board.spacing_mm * (board.height_n + 3));
    const fs::path toml = dir / fmt::format("pose{:02}.toml", i),
                   captures = dir / fmt::format("pose{:02}", i);
    write_file(toml, devices_toml(false) + object);
    const RunResult run =
        run_fringetwin({"render", toml.string(), "--out", captures.string(), "--seed", std::to_string(i)});
    if (run.exit_code != 0) throw std::runtime_error(run.err);
    folders.push_back(captures.string());
  }
  return folders;
}

}  // namespace fringetwin::testing
