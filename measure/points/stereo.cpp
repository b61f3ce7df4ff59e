// SPDX-License-Identifier: Apache-2.0
// The pixel of camera 0 is exact, so the only unknown is the depth s along its (undistorted) ray.
// s is where the coordinate map of camera 1, read at the distorted projection of the point, equals
// the coordinate decoded at the pixel: the epipolar curve is followed without being drawn.
#include <algorithm>
#include <cmath>
#include <utility>

#include "measure/points/depth_solver.hpp"
#include "measure/points/epipolar_table.hpp"
#include "measure/points/hidden_matches.hpp"
#include "measure/points/point_rows.hpp"
#include "measure/points/points.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/statistics.hpp"
#include "twin/base/stopwatch.hpp"

namespace fringetwin::measure {
namespace {

constexpr double kMostRelativeSigma = 0.05;  ///< sigma / depth beyond which a point says nothing
constexpr double kSmallestSine = 0.005;      ///< of the angle between the two rays
constexpr double kSameRootPx = 3.0;          ///< roots closer than this are one match and its noise
constexpr double kLargestResidualPx = 3.0;   ///< two directions that disagree by more are a false match
constexpr double kSteepest = 8.0;            ///< depth over lateral step of neighbours on one surface
constexpr int kWindow = 3;                   ///< radius of the neighbourhood that decides ambiguities

enum class State : unsigned char { none, no_match, matched, ambiguous, rejected, too_uncertain };

struct Match {
  double depth_mm = 0.0;
  float sigma_mm = 0.0f, residual_px = 0.0f;
};

struct Alternatives {  ///< several places in camera 1 fit
  std::size_t pixel;
  std::vector<Match> matches;
};

struct Setup {
  const Twin& twin;
  const Camera& cam0;
  const Camera& cam1;
  Pose T_cam1_cam0;
  const DirectionDecode* left[2] = {nullptr, nullptr};
  const CoordinateMap* maps[2] = {nullptr, nullptr};
  const EpipolarTable* table = nullptr;
  int count = 0;
};

struct Work {
  Image<Eigen::Vector3d> ray = {};  ///< to_points() makes points of them
  Image<Match> match = {};
  Image<State> state = {};
  std::vector<std::vector<Alternatives>> alternatives = {};  ///< per row
};

bool plausible(const Setup& setup, const Eigen::Vector3d& d, const DepthSolution& s) {
  const Lens& lens = setup.cam1.lens;
  if (s.q_px.x() < -0.5 || s.q_px.y() < -0.5 || s.q_px.x() > lens.width() - 0.5 ||
      s.q_px.y() > lens.height() - 0.5)
    return false;
  const double cosine = (setup.T_cam1_cam0.rotation * d).dot(s.p_mm.normalized());
  return 1.0 - cosine * cosine >= kSmallestSine * kSmallestSine && s.residual_px <= kLargestResidualPx;
}

/// Returns whether, with a calibrated projector, the point lies on the projector's sheet of light. Half a
/// period is far more than calibration errors and far less than what a false match makes.
bool lit_by_its_column(const Setup& setup, const Eigen::Vector3d& d, double depth_mm,
                       const double* coordinate_px) {
  if (!setup.twin.projector) return true;
  const Projector& projector = *setup.twin.projector;
  const Eigen::Vector3d p_world = setup.cam0.T_cam_world.inverse() * (depth_mm * d);
  const auto q = projector.lens.project(projector.T_proj_world * p_world);
  if (!q) return false;
  for (int k = 0; k < setup.count; ++k) {
    const DirectionDecode& direction = *setup.left[k];
    const int axis = direction.axis == Axis::x ? 0 : 1;
    const double half_period = 0.5 * direction.pitches_px[direction.finest];
    if (!(std::abs((*q)[axis] - coordinate_px[k]) <= half_period)) return false;
  }
  return true;
}

void match_pixel(const Setup& setup, int x, int y, Work& work) {
  CoordinateTarget targets[2];
  double coordinates[2] = {0, 0};
  for (int k = 0; k < setup.count; ++k) {
    coordinates[k] = setup.left[k]->coordinate_px(x, y);
    if (!std::isfinite(coordinates[k])) return;
    targets[k] = {coordinates[k], coordinate_sigma(*setup.left[k], x, y)};
  }
  State& state = work.state(x, y);
  state = State::no_match;
  const auto d = setup.cam0.lens.unproject({static_cast<double>(x), static_cast<double>(y)});
  if (!d) return;
  work.ray(x, y) = *d;
  double starts[EpipolarTable::kMostCandidates];
  const int n = setup.table->candidates(*d, coordinates[0], starts);
  std::vector<Match> found;
  Eigen::Vector2d places[EpipolarTable::kMostCandidates];
  bool failed = false, uncertain = false;
  for (int k = 0; k < n; ++k) {
    DepthSolution s;
    const SolveStatus status = solve_depth_in_maps(setup.cam1.lens, setup.T_cam1_cam0, *d, setup.maps,
                                                   targets, setup.count, starts[k], s);
    failed |= status == SolveStatus::failed;
    if (status != SolveStatus::ok) continue;
    if (!plausible(setup, *d, s) || !lit_by_its_column(setup, *d, s.depth_mm, coordinates)) {
      failed = true;
      continue;
    }
    if (!(s.sigma_mm <= kMostRelativeSigma * s.depth_mm)) {
      uncertain = true;
      continue;
    }
    bool known = false;
    for (std::size_t i = 0; i < found.size(); ++i) known |= (places[i] - s.q_px).norm() < kSameRootPx;
    if (known) continue;
    places[found.size()] = s.q_px;
    found.push_back({s.depth_mm, static_cast<float>(s.sigma_mm), static_cast<float>(s.residual_px)});
  }
  if (found.size() == 1) {
    state = State::matched;
    work.match(x, y) = found[0];
  } else if (found.size() > 1) {
    state = State::ambiguous;
    work.alternatives[y].push_back({work.match.index(x, y), std::move(found)});
  } else if (uncertain) {  // the rays meet, whatever other places do
    state = State::too_uncertain;
  } else if (failed) {
    state = State::rejected;
  }
}

/// Returns the lateral step to the next pixel per mm of depth, from the rays at the image's middle row and
/// column: only a scale for what a depth jump is.
double ray_step(const Lens& lens) {
  const double cx = 0.5 * (lens.width() - 1), cy = 0.5 * (lens.height() - 1);
  const auto a = lens.unproject({cx, cy}), b = lens.unproject({cx + 1.0, cy + 1.0});
  return a && b ? (*a - *b).norm() / std::sqrt(2.0) : 1e-3;
}

bool same_surface(const Match& a, const Match& b, double pixels, double step) {
  const double noise = 5.0 * std::hypot(static_cast<double>(a.sigma_mm), static_cast<double>(b.sigma_mm));
  return std::abs(a.depth_mm - b.depth_mm) <= kSteepest * pixels * step * a.depth_mm + noise;
}

/// Gives ambiguous pixels the alternative nearest to the median depth of their uniquely matched
/// neighbours, if it can lie on the same surface.
void decide_ambiguous(Work& work, double step) {
  const Image<State> before = work.state;
  for (const auto& row : work.alternatives)
    for (const Alternatives& a : row) {
      const int px = static_cast<int>(a.pixel) % work.match.width,
                py = static_cast<int>(a.pixel) / work.match.width;
      std::vector<double> depths;
      for (int y = std::max(0, py - kWindow); y <= std::min(work.match.height - 1, py + kWindow); ++y)
        for (int x = std::max(0, px - kWindow); x <= std::min(work.match.width - 1, px + kWindow); ++x)
          if (before(x, y) == State::matched) depths.push_back(work.match(x, y).depth_mm);
      if (depths.empty()) continue;
      Match expected{.depth_mm = upper_median(depths)};
      const auto best = std::ranges::min_element(a.matches, [&](const Match& u, const Match& v) {
        return std::abs(u.depth_mm - expected.depth_mm) < std::abs(v.depth_mm - expected.depth_mm);
      });
      if (!same_surface(*best, expected, kWindow, step)) continue;
      work.match.data[a.pixel] = *best;
      work.state.data[a.pixel] = State::matched;
    }
}

/// Takes away matches without two neighbours on the same surface: they are accidents, or nothing tells them
/// from such where the neighbours are too uncertain.
void reject_isolated(Work& work, double step) {
  const Image<State> before = work.state;
#pragma omp parallel for schedule(static)
  for (int y = 0; y < work.match.height; ++y)
    for (int x = 0; x < work.match.width; ++x) {
      if (before(x, y) != State::matched) continue;
      int support = 0, uncertain = 0;
      for (int v = std::max(0, y - 1); v <= std::min(work.match.height - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(work.match.width - 1, x + 1); ++u)
          if (before(u, v) == State::too_uncertain)
            ++uncertain;
          else if ((u != x || v != y) && before(u, v) == State::matched)
            support += same_surface(work.match(x, y), work.match(u, v), 1.5, step);
      if (support < 2) work.state(x, y) = support + uncertain < 2 ? State::rejected : State::too_uncertain;
    }
}

/// Puts the point of each match in the place of its ray, mm in camera 0; NaN where there is none.
void to_points(Work& work) {
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < work.ray.data.size(); ++i)
    if (work.state.data[i] == State::matched)
      work.ray.data[i] *= work.match.data[i].depth_mm;
    else
      work.ray.data[i].setConstant(kNaN);
}

/// Takes away matches of surfaces that camera 1 does not see (hidden_matches.hpp): they have none.
/// After to_points().
void leave_out_hidden(const Setup& setup, Work& work) {
  ImageF sigma_mm(work.match.width, work.match.height, 0.0F);
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < sigma_mm.data.size(); ++i)
    if (work.state.data[i] == State::matched) sigma_mm.data[i] = work.match.data[i].sigma_mm;
  const ImageU8 hidden = hidden_matches(work.ray, sigma_mm, setup.T_cam1_cam0.inverse().translation_mm,
                                        ray_step(setup.cam1.lens));
  for (std::size_t i = 0; i < hidden.data.size(); ++i)
    if (hidden.data[i] != 0) work.state.data[i] = State::no_match;
}

/// After to_points(). Frees what it works on.
PointCloud collect(const Setup& setup, Work work, TriangulationSummary* summary) {
  std::vector<PointRow> rows(work.match.height);
#pragma omp parallel for schedule(dynamic, 8)
  for (int y = 0; y < work.match.height; ++y) {
    PointRow& row = rows[y];
    row.summary.n_ambiguous = work.alternatives[y].size();
    for (int x = 0; x < work.match.width; ++x) {
      const State state = work.state(x, y);
      row.summary.n_candidates += state != State::none;
      row.summary.n_no_match += state == State::no_match;
      row.summary.n_rejected +=
          state == State::rejected || state == State::ambiguous || state == State::too_uncertain;
      row.summary.n_too_uncertain += state == State::too_uncertain;
      if (state != State::matched) continue;
      const Eigen::Vector2d pixel(x, y);
      const Match& m = work.match(x, y);
      row.add(pixel, work.ray(x, y), static_cast<double>(m.sigma_mm), static_cast<double>(m.residual_px));
    }
  }
  work = {};
  return join_rows(std::move(rows), setup.cam0.T_cam_world.inverse(), summary);
}

/// Returns how much the coordinate changes along the epipolar curve, median over the image: tells which
/// decoded direction can find the match.
double sensitivity(const Lens& lens, const Pose& T_cam1_cam0, const CoordinateMap& map) {
  std::vector<double> values;
  const ImageD& image = map.image();
  const int step = std::max(1, image.height / 60);
  for (int y = step; y < image.height - 1; y += step)
    for (int x = step; x < image.width - 1; x += step) {
      MapSample sample;
      Eigen::Matrix<double, 2, 3> J;
      if (!std::isfinite(image(x, y)) || !map.sample(x, y, sample)) continue;
      const auto ray = lens.unproject({static_cast<double>(x), static_cast<double>(y)});
      if (!ray || !lens.project(*ray, &J)) continue;
      const Eigen::Vector2d motion = (J * T_cam1_cam0.translation_mm).normalized();
      values.push_back(std::abs(sample.d_dx * motion.x() + sample.d_dy * motion.y()));
    }
  return values.empty() ? 0.0 : upper_median(values);
}

}  // namespace

PointCloud triangulate_stereo(const Twin& twin, const CameraDecode& left, const CameraDecode& right,
                              TriangulationSummary* summary) {
  if (twin.cameras.size() < 2)
    throw UserError(ExitCode::usage, twin.file.string(), "stereo triangulation needs two cameras",
                    "add a [[camera]] or set triangulate = \"projector\"");
  Setup setup{twin, twin.cameras[0], twin.cameras[1], {}};
  setup.T_cam1_cam0 = setup.cam1.T_cam_world * setup.cam0.T_cam_world.inverse();
  if (!(setup.T_cam1_cam0.translation_mm.norm() > 0.0))
    throw UserError(ExitCode::usage, twin.file.string(), "the two cameras stand at the same place",
                    "check rt_cam_world of both");
  std::vector<CoordinateMap> maps;
  maps.reserve(2);
  for (const Axis axis : {Axis::x, Axis::y}) {
    const DirectionDecode *l = left.direction(axis), *r = right.direction(axis);
    if (!l || !r) continue;
    maps.emplace_back(r->coordinate_px, r->coordinate_sigma_px, r->smoothed);
    setup.left[setup.count] = l;
    setup.maps[setup.count] = &maps[setup.count];
    ++setup.count;
  }
  if (setup.count == 0)
    throw UserError(ExitCode::usage, twin.file.string(), "no fringe direction was decoded",
                    "check [fringes]");
  if (setup.count == 2 && sensitivity(setup.cam1.lens, setup.T_cam1_cam0, *setup.maps[1]) >
                              sensitivity(setup.cam1.lens, setup.T_cam1_cam0, *setup.maps[0])) {
    std::swap(setup.left[0], setup.left[1]);
    std::swap(setup.maps[0], setup.maps[1]);
  }
  const Stopwatch watch;
  const EpipolarTable table(setup.cam1.lens, setup.T_cam1_cam0, *setup.maps[0]);
  setup.table = &table;

  Work work{.ray = Image<Eigen::Vector3d>(left.width(), left.height(), Eigen::Vector3d::Zero()),
            .match = Image<Match>(left.width(), left.height()),
            .state = Image<State>(left.width(), left.height(), State::none)};
  work.alternatives.resize(left.height());
#pragma omp parallel for schedule(dynamic, 8)
  for (int y = 0; y < left.height(); ++y)
    for (int x = 0; x < left.width(); ++x) match_pixel(setup, x, y, work);
  const double match_s = watch.elapsed().wall_s;
  const double step = ray_step(setup.cam0.lens);
  decide_ambiguous(work, step);
  to_points(work);
  leave_out_hidden(setup, work);
  reject_isolated(work, step);
  PointCloud cloud = collect(setup, std::move(work), summary);
  if (summary) summary->match_s = match_s;
  return cloud;
}

}  // namespace fringetwin::measure
