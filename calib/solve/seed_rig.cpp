// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "calib/board/corner_order.hpp"
#include "calib/solve/seed.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/statistics.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::calib {
namespace {

/// A board's pose from one view scatters by up to this fraction of the board's diagonal; a smaller
/// displacement between two devices' poses is therefore no disagreement.
constexpr double kPoseTolerance = 0.05;

std::vector<Eigen::Vector3d> board_points(const Board& board, const Pose& T) {
  std::vector<Eigen::Vector3d> points;
  for (const std::size_t i : {std::size_t{0}, static_cast<std::size_t>(board.width_n - 1),
                              board.corners() - static_cast<std::size_t>(board.width_n), board.corners() - 1})
    points.push_back(T * board.point_mm(i));
  return points;
}

/// rms distance between the board where b sees it and where a's pose of it puts it.
double disagreement_mm(const Board& board, const Pose& T_b_a, const Pose& T_a_board, const Pose& T_b_board) {
  const auto in_a = board_points(board, T_a_board), in_b = board_points(board, T_b_board);
  double sum = 0.0;
  for (std::size_t i = 0; i < in_a.size(); ++i) sum += (T_b_a * in_a[i] - in_b[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(in_a.size()));
}

struct Pair {
  int a = 0, b = 0;
  Pose T_b_a = {};
  std::vector<int> frames = {};  ///< shared
  std::vector<double> disagreement_mm = {};
  double tolerance_mm = 0.0;
  bool agrees(std::size_t i) const { return disagreement_mm[i] <= tolerance_mm; }
};

/// The transform most shared views agree on (the one whose median disagreement is least), then the best over
/// those that agree. nullopt without a shared view.
std::optional<Pair> fit_pair(const Board& board, const std::vector<AloneFit>& alone, int a, int b) {
  Pair pair{.a = a, .b = b};
  const auto& in_a = alone[a].T_device_board;
  const auto& in_b = alone[b].T_device_board;
  for (const auto& [frame, T] : in_a)
    if (in_b.contains(frame)) pair.frames.push_back(frame);
  if (pair.frames.empty()) return std::nullopt;
  const auto all = [&](const Pose& T_b_a) {
    std::vector<double> d;
    for (const int f : pair.frames) d.push_back(disagreement_mm(board, T_b_a, in_a.at(f), in_b.at(f)));
    return d;
  };
  double least = INFINITY;
  for (const int f : pair.frames) {
    const Pose candidate = in_b.at(f) * in_a.at(f).inverse();
    std::vector<double> disagreements_mm = all(candidate);
    const double m = upper_median(disagreements_mm);
    if (m >= least) continue;
    least = m;
    pair.T_b_a = candidate;
  }
  pair.disagreement_mm = all(pair.T_b_a);
  pair.tolerance_mm = std::max(kPoseTolerance * board.diagonal_mm(), 4.0 * least);
  std::vector<Eigen::Vector3d> from, to;
  for (std::size_t i = 0; i < pair.frames.size(); ++i) {
    if (!pair.agrees(i)) continue;
    for (const auto& p : board_points(board, in_a.at(pair.frames[i]))) from.push_back(p);
    for (const auto& p : board_points(board, in_b.at(pair.frames[i]))) to.push_back(p);
  }
  pair.T_b_a = rigid_alignment(from, to);
  pair.disagreement_mm = all(pair.T_b_a);
  return pair;
}

// --- what can be wrong with a view that disagrees

class Explanation {
 public:
  Explanation(const Observations& o, const MrcalModel& model, const std::vector<AloneFit>& alone,
              const Pair& pair, int frame)
      : o_(o), model_(model), alone_(alone), pair_(pair), frame_(frame) {}

  /// "the corners of left run in the reverse order…", or empty when nothing simple explains it. `blamed`:
  /// which of the two devices the other devices disagree with, or -1.
  std::string text(int blamed) const {
    std::string found = swapped();
    if (found.empty()) found = another_order(blamed);
    if (found.empty()) found = another_size();
    return found;
  }

 private:
  const View& view(int device) const { return *o_.find(device, frame_); }
  const AloneFit& fit(int device) const { return alone_[device]; }
  const std::string& name(int device) const { return o_.devices[device].name; }
  const Pose& pose(int device) const { return fit(device).T_device_board.at(frame_); }
  std::optional<BoardPose> pose_of(const std::vector<Corner>& corners, int device) const {
    return board_pose(o_.board, corners, model_, fit(device).intrinsics);
  }
  bool agree(const Pose& T_a, const Pose& T_b) const {
    return disagreement_mm(o_.board, pair_.T_b_a, T_a, T_b) <= pair_.tolerance_mm;
  }

  std::string swapped() const {
    const auto a = pose_of(view(pair_.b).corners, pair_.a), b = pose_of(view(pair_.a).corners, pair_.b);
    if (!a || !b || !agree(a->T_device_board, b->T_device_board)) return "";
    return fmt::format("the corners of {} and {} are swapped", name(pair_.a), name(pair_.b));
  }

  std::string another_order(int blamed) const {
    for (const CornerOrder& order : kCornerOrders) {
      if (order.transpose && o_.board.width_n != o_.board.height_n) continue;
      const auto b = pose_of(reordered(o_.board, view(pair_.b).corners, order), pair_.b);
      if (!b || !agree(pose(pair_.a), b->T_device_board)) continue;
      if (blamed >= 0) return fmt::format("the corners of {} {}", name(blamed), order.what);
      return fmt::format("the corners of {} or of {} {}", name(pair_.b), name(pair_.a), order.what);
    }
    return "";
  }

  /// A board s times as large looks like ours at 1/s of the distance: R (s p_a) + t = s p_b.
  std::string another_size() const {
    const auto in_a = board_points(o_.board, pose(pair_.a)), in_b = board_points(o_.board, pose(pair_.b));
    double numerator = 0.0, denominator = 0.0;
    const Eigen::Vector3d& t = pair_.T_b_a.translation_mm;
    std::vector<Eigen::Vector3d> d;
    for (std::size_t i = 0; i < in_a.size(); ++i) {
      d.push_back(in_b[i] - pair_.T_b_a.rotation * in_a[i]);
      numerator += d.back().dot(t);
      denominator += d.back().squaredNorm();
    }
    const double s = numerator / denominator;
    if (!(s > 0.05 && s < 20.0)) return "";
    double sum = 0.0;
    for (const auto& v : d) sum += (s * v - t).squaredNorm();
    const double left_mm = std::sqrt(sum / static_cast<double>(d.size()));
    if (left_mm > pair_.tolerance_mm * std::max(1.0, s)) return "";
    return fmt::format(
        "it shows another board: its corners are {:.3g} mm apart, those of the other views {:.3g} mm",
        s * o_.board.spacing_mm, o_.board.spacing_mm);
  }

  const Observations& o_;
  const MrcalModel& model_;
  const std::vector<AloneFit>& alone_;
  const Pair& pair_;
  int frame_;
};

/// Returns the device that takes part in every disagreement of this frame, when there is exactly one.
int blamed_device(const std::vector<Pair>& pairs, int frame, int n_devices) {
  std::vector<int> bad(static_cast<std::size_t>(n_devices), 0);
  int n_bad = 0;
  for (const Pair& pair : pairs)
    for (std::size_t i = 0; i < pair.frames.size(); ++i)
      if (pair.frames[i] == frame && !pair.agrees(i)) {
        ++bad[pair.a];
        ++bad[pair.b];
        ++n_bad;
      }
  int blamed = -1;
  for (std::size_t d = 0; d < bad.size(); ++d)
    if (n_bad > 0 && bad[d] == n_bad) blamed = blamed >= 0 ? -2 : static_cast<int>(d);
  return std::max(blamed, -1);
}

void check_agreement(const Observations& o, const MrcalModel& model, const std::vector<AloneFit>& alone,
                     const std::vector<Pair>& pairs) {
  for (const Pair& pair : pairs)
    for (std::size_t i = 0; i < pair.frames.size(); ++i) {
      if (pair.agrees(i)) continue;
      const int frame = pair.frames[i];
      const int blamed = blamed_device(pairs, frame, static_cast<int>(o.devices.size()));
      const std::string why = Explanation(o, model, alone, pair, frame).text(blamed);
      if (why.empty()) continue;  // perhaps only a poor pose; the solve decides
      const View* view = o.find(blamed >= 0 ? blamed : pair.b, frame);
      throw UserError(ExitCode::input, o.where(*view), why,
                      fmt::format("{} and {} put this board {:.1f} mm apart; correct or remove the view",
                                  o.devices[pair.a].name, o.devices[pair.b].name, pair.disagreement_mm[i]));
    }
}

/// Device poses along the pairs with most shared views, from device 0 on.
std::vector<Pose> connect(const Observations& o, const std::vector<Pair>& pairs) {
  const std::size_t n = o.devices.size();
  std::vector<Pose> T_device_ref(n);
  std::vector<bool> known(n, false);
  known[0] = true;
  for (std::size_t step = 1; step < n; ++step) {
    const Pair* best = nullptr;
    for (const Pair& pair : pairs)
      if (known[pair.a] != known[pair.b] && (!best || pair.frames.size() > best->frames.size())) best = &pair;
    if (!best) {
      const auto alone = std::ranges::find(known, false) - known.begin();
      throw UserError(ExitCode::input, o.devices[alone].name, "shares no view with the other devices",
                      "are the frame numbers in the file names the same?");
    }
    const auto a = static_cast<std::size_t>(best->a), b = static_cast<std::size_t>(best->b);
    if (known[a])
      T_device_ref[b] = best->T_b_a * T_device_ref[a];
    else
      T_device_ref[a] = best->T_b_a.inverse() * T_device_ref[b];
    known[a] = known[b] = true;
  }
  return T_device_ref;
}

}  // namespace

Seed seed_rig(const Observations& o, const std::string& lensmodel, const std::vector<AloneFit>& alone) {
  const int n = static_cast<int>(o.devices.size());
  std::vector<Pair> pairs;
  for (int a = 0; a < n; ++a)
    for (int b = a + 1; b < n; ++b)
      if (auto pair = fit_pair(o.board, alone, a, b)) pairs.push_back(*pair);
  check_agreement(o, calibratable_model(lensmodel), alone, pairs);
  Seed seed;
  seed.lensmodel = lensmodel;
  for (const AloneFit& fit : alone) seed.intrinsics.push_back(fit.intrinsics);
  seed.T_device_ref = connect(o, pairs);
  for (std::size_t f = 0; f < o.frames.size(); ++f) {
    const int frame = static_cast<int>(f);
    // The device with most corners of it; the first of several.
    const View* best = nullptr;
    for (const View& view : o.views)
      if (view.frame == frame && alone[view.device].T_device_board.contains(frame) &&
          (!best || view.n_seen() > best->n_seen()))
        best = &view;
    if (!best)
      throw UserError(ExitCode::input, "view " + o.frames[f], "no device sees enough of the board",
                      "remove the view");
    const auto d = static_cast<std::size_t>(best->device);
    seed.T_ref_board.push_back(seed.T_device_ref[d].inverse() * alone[d].T_device_board.at(frame));
  }
  return seed;
}

}  // namespace fringetwin::calib
