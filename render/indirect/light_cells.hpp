// SPDX-License-Identifier: Apache-2.0
// Finds the light that reaches the surfaces of a scene over others: cells of the surfaces that light to a
// camera can have come over, and for each the sums of its irradiance (docs/PHYSICS.md, "Interreflection").
// A trace gathers the light of its own points over one surface ray by ray, and takes what that surface has
// got of others from its cell. Internal to render/ (includes volk).
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "render/indirect/cell_grid.hpp"
#include "render/indirect/cell_transfer.hpp"
#include "render/indirect/gatherer.hpp"

namespace fringetwin::render {

class LightCells {
 public:
  static constexpr std::size_t kMostMembers = 4;  ///< of a cell
  /// Finds the cells; the scene must have been uploaded. `pass`: the first of the trace. `seen`: places that
  /// the camera sees, a few thousand all over its image.
  LightCells(TraceDevice& device, const TraceJob& job, const PassPlan& pass,
             const std::vector<SurfacePlace>& seen);

  /// Uploads the cells and their light for the sums of a pass. Throws UserError(device) where they do not
  /// fit.
  void upload(TraceDevice& device, const TraceJob& job, const PassPlan& pass, bool first_pass) const;

  /// Returns the number of cells; none where no surface gets light from another.
  std::size_t size() const { return table_.size(); }
  /// Returns how the shaders find them.
  CellLookup lookup() const { return {grid_.middle_mm, grid_.per_mm, table_.mask()}; }

 private:
  /// Places of a cell that stand for it, chosen at random from those that were met.
  struct Members {
    std::array<SurfacePlace, kMostMembers> places;
    std::uint32_t met = 0;
    std::size_t size() const { return met < kMostMembers ? met : kMostMembers; }
  };

  static std::vector<SurfacePlace> places_met_from(TraceDevice& device, const TraceJob& job,
                                                   const PassPlan& pass, std::vector<SurfacePlace> points);
  void find_cells(const std::vector<SurfacePlace>& met);
  std::int32_t meet(const SurfacePlace& place);
  std::int32_t add_member(std::uint32_t key, const SurfacePlace& place);
  void find_transfer(Gatherer& gatherer, const PassPlan& pass);
  std::vector<SurfacePlace> points_of(std::size_t first_cell, std::size_t end_cell) const;
  template <class Use>
  void gather_cells(Gatherer& gatherer, std::size_t first_cell, std::size_t end_cell, const Use& use) const;
  void add_light(const Gathered& from, std::size_t point, std::size_t cell, const PassPlan& pass,
                 std::vector<float>& light) const;

  CellGrid grid_;
  CellTable table_;
  std::vector<Members> members_;  ///< of each cell
  std::size_t n_gathered_ = 0;    ///< cells that have light; those that were met last have none
  std::size_t settled_ = 0;       ///< cells whose members are chosen
  CellTransfer transfer_;
  std::vector<float> light_of_first_pass_;  ///< [cell][channel]: over one surface
};

}  // namespace fringetwin::render
