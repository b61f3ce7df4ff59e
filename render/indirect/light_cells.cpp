// SPDX-License-Identifier: Apache-2.0
#include "render/indirect/light_cells.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <unordered_map>
#include <utility>

#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

// The longest side of what the camera sees lit is divided into so many cells: light that has come over two
// surfaces is smooth, and a point that gathers takes the mean over many cells (accuracy: docs/PHYSICS.md).
constexpr int kCellsAcross = 96;
// Cells of their own have places that were met so often; others are part of coarser ones, which may be met
// later, too.
constexpr std::uint32_t kLeastMet = 4;
constexpr std::size_t kMostCells = 100000;
// Cells that are met by light over so many others only send nothing on.
constexpr int kMostRounds = 6;
constexpr std::size_t kMostRays = 256U << 20;  // of all members: bounds the time, and the memory of shares

// Returns the directions of each place from which cells are looked for.
std::size_t directions_of_look(const TraceJob& job) {
  return std::clamp<std::size_t>(static_cast<std::size_t>(job.twin.render.bounce_samples) / 8 * 2, 64, 256);
}

// Returns the directions of each member of so many cells: all members of one have half as many as a place
// that is seen.
std::size_t directions_of(const TraceJob& job, std::size_t cells) {
  const std::size_t most = kMostRays / (LightCells::kMostMembers * std::max<std::size_t>(cells, 1)) / 2 * 2;
  return std::clamp<std::size_t>(static_cast<std::size_t>(job.twin.render.bounce_samples) / 16 * 2, 16,
                                 std::max<std::size_t>(most, 16));
}

// The mixing function of splitmix64.
std::uint64_t mixed(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace

LightCells::LightCells(TraceDevice& device, const TraceJob& job, const PassPlan& pass,
                       const std::vector<SurfacePlace>& seen) {
  std::vector<Eigen::Vector3f> all, lit;
  for (const SurfacePlace& place : seen) (place.number > 0.0F ? lit : all).push_back(place.p_mm);
  const std::vector<Eigen::Vector3f>& reached = lit.empty() ? all : lit;
  grid_ = grid_around(reached, kCellsAcross);
  if (grid_.per_mm == 0.0F) return;
  find_cells(places_met_from(device, job, pass, seen));
  Gatherer gatherer(device, job, pass, directions_of(job, size()), true);
  find_transfer(gatherer, pass);
}

// Returns what light that reaches these places over another surface can have come over.
std::vector<SurfacePlace> LightCells::places_met_from(TraceDevice& device, const TraceJob& job,
                                                      const PassPlan& pass,
                                                      std::vector<SurfacePlace> points) {
  Gatherer gatherer(device, job, pass, directions_of_look(job), true);
  std::vector<SurfacePlace> met;
  for (std::size_t i = 0; i < points.size(); ++i) points[i].number = static_cast<float>(i);
  for (std::size_t first = 0; first < points.size(); first += gatherer.most_at_a_time()) {
    const Gathered from =
        gatherer.gather({&points[first], std::min(gatherer.most_at_a_time(), points.size() - first)});
    for (std::size_t i = 0; i < from.n; ++i)
      std::ranges::copy_if(from.met(i), std::back_inserter(met),
                           [](const SurfacePlace& place) { return place.number > 0.0F; });
  }
  return met;
}

// Numbers the cells of places that light comes from: coarse ones for all, fine ones where it does often. Half
// of the room is kept for coarse ones that are met later.
void LightCells::find_cells(const std::vector<SurfacePlace>& met) {
  std::vector<std::uint32_t> keys;
  std::unordered_map<std::uint32_t, std::uint32_t> times;
  for (const SurfacePlace& place : met) {
    keys.push_back(grid_.key(place.p_mm, place.n_geometric));
    if (keys.back() == 0) continue;
    ++times[keys.back()];
    add_member(grid_.key(place.p_mm, place.n_geometric, CELL_COARSER), place);
  }
  for (std::size_t i = 0; i < met.size(); ++i)
    if (keys[i] != 0 && times[keys[i]] >= kLeastMet &&
        (table_.size() < kMostCells / 2 || table_.find(keys[i]) >= 0))
      add_member(keys[i], met[i]);
}

// Returns the number of the cell that stands for a place, which becomes one of its members where its members
// are not chosen yet; -1 where there is none.
std::int32_t LightCells::meet(const SurfacePlace& place) {
  const std::uint32_t key = grid_.key(place.p_mm, place.n_geometric);
  if (key == 0) return -1;
  const std::int32_t fine = table_.find(key);
  return fine >= 0 ? fine : add_member(grid_.key(place.p_mm, place.n_geometric, CELL_COARSER), place);
}

// Lets a place stand for the cell of a key, or not: members are places of it at random.
std::int32_t LightCells::add_member(std::uint32_t key, const SurfacePlace& place) {
  if (table_.size() >= kMostCells && table_.find(key) < 0) return -1;
  const std::int32_t cell = table_.find_or_add(key);
  if (static_cast<std::size_t>(cell) >= members_.size()) members_.emplace_back();
  if (static_cast<std::size_t>(cell) < settled_) return cell;
  Members& members = members_[static_cast<std::size_t>(cell)];
  const std::uint32_t before = members.met++;
  const std::uint64_t at =
      before < kMostMembers ? before : mixed(std::uint64_t{key} << 32 | before) % (std::uint64_t{before} + 1);
  if (at < kMostMembers) members.places[at] = place;
  return cell;
}

// Returns the members of some cells one after the other, each with a seed of its own.
std::vector<SurfacePlace> LightCells::points_of(std::size_t first_cell, std::size_t end_cell) const {
  std::vector<SurfacePlace> points;
  for (std::size_t cell = first_cell; cell < end_cell; ++cell)
    for (std::size_t k = 0; k < members_[cell].size(); ++k) {
      points.push_back(members_[cell].places[k]);
      points.back().number = static_cast<float>((cell * kMostMembers + k) % (1U << 24));
    }
  return points;
}

// Lets the members of some cells gather; use(cell, gathered, point, last of its cell).
template <class Use>
void LightCells::gather_cells(Gatherer& gatherer, std::size_t first_cell, std::size_t end_cell,
                              const Use& use) const {
  const std::vector<SurfacePlace> points = points_of(first_cell, end_cell);
  std::size_t cell = first_cell, member = 0;
  for (std::size_t first = 0; first < points.size(); first += gatherer.most_at_a_time()) {
    const std::size_t n = std::min(gatherer.most_at_a_time(), points.size() - first);
    const Gathered from = gatherer.gather({&points[first], n});
    for (std::size_t i = 0; i < n; ++i) {
      const bool last = ++member == members_[cell].size();
      use(cell, from, i, last);
      if (!last) continue;
      ++cell;
      member = 0;
    }
  }
}

// Adds what a member gathered to the light of its cell, in the order of the shaders.
void LightCells::add_light(const Gathered& from, std::size_t point, std::size_t cell, const PassPlan& pass,
                           std::vector<float>& light) const {
  const auto share = 1.0F / static_cast<float>(members_[cell].size());
  float* of_cell = &light[cell * light_channels(pass)];
  of_cell[0] += share * from.sum(0, point);
  for (std::size_t c = 2; c < pass.channels(); ++c) of_cell[c - 1] += share * from.sum(c, point);
}

// Follows the light back from cell to cell until no new ones are met.
void LightCells::find_transfer(Gatherer& gatherer, const PassPlan& pass) {
  for (int round = 0; round < kMostRounds && transfer_.rows() < members_.size(); ++round) {
    const std::size_t first = transfer_.rows(), end = members_.size();
    settled_ = end;
    light_of_first_pass_.resize(end * light_channels(pass), 0.0F);
    std::vector<CellTransfer::Share> shares;
    gather_cells(gatherer, first, end,
                 [&](std::size_t cell, const Gathered& from, std::size_t point, bool last) {
                   add_light(from, point, cell, pass, light_of_first_pass_);
                   const float directions =
                       static_cast<float>(from.directions * members_[cell].size()) * from.leaving(point);
                   for (const SurfacePlace& place : from.met(point)) {
                     if (!(place.number > 0.0F)) continue;
                     const std::int32_t other = meet(place);
                     if (other >= 0) shares.push_back({other, place.number / directions});
                   }
                   if (last) transfer_.add_row(std::exchange(shares, {}));
                 });
  }
  n_gathered_ = transfer_.rows();
  while (transfer_.rows() < members_.size()) transfer_.add_row({});
  light_of_first_pass_.resize(members_.size() * light_channels(pass), 0.0F);
}

void LightCells::upload(TraceDevice& device, const TraceJob& job, const PassPlan& pass,
                        bool first_pass) const {
  std::vector<float> light = light_of_first_pass_;
  if (!first_pass) {
    TraceJob over_one_surface = job;
    over_one_surface.cells.reset();
    Gatherer gatherer(device, over_one_surface, pass, directions_of(job, size()), false);
    light.assign(size() * light_channels(pass), 0.0F);
    gather_cells(gatherer, 0, n_gathered_,
                 [&](std::size_t cell, const Gathered& from, std::size_t point, bool) {
                   add_light(from, point, cell, pass, light);
                 });
  }
  const int bounces = job.twin.render.bounces;
  const auto times = bounces >= kAllBounces ? std::nullopt : std::optional<int>(bounces - 2);
  light = transfer_.spread(light, light_channels(pass), times);
  const std::size_t most = device.vulkan().limits().maxTexelBufferElements;
  if (light.size() > most || table_.entries().size() > most)
    throw UserError(ExitCode::device, device.vulkan().info().name,
                    fmt::format("its tables hold {} numbers, light over several surfaces needs {}", most,
                                std::max(light.size(), table_.entries().size())),
                    "render with bounces = 1, or use another device");
  device.fill(BIND_CELL_TABLE, table_.entries());
  device.fill(BIND_CELL_LIGHT, light);
}

}  // namespace fringetwin::render
