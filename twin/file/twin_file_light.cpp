// SPDX-License-Identifier: Apache-2.0
// Light of the room, and factors of each image of the sequence: [room], light_factors, ambient_factors and
// exposure_factors of twin.toml.
#include <fmt/format.h>

#include "twin/file/plain_keys.hpp"
#include "twin/file/twin_file.hpp"

namespace fringetwin {
namespace {

/// A lamp that flickers, or an exposure that is not kept, stays well within this.
constexpr double kSmallest = 1e-3, kLargest = 1e3;
constexpr double kBrightestLamp = 1e9;

/// Returns the factors of a key, none where it is left out. Refuses any other number of them than that of the
/// sequence's images.
std::vector<double> read_factors(const TomlTable& table, const std::string& key, const NumberRange& range,
                                 std::size_t n_images) {
  const auto factors = table.numbers(key, range);
  if (!factors) return {};
  if (factors->size() != n_images)
    table.fail(key, fmt::format("has {} numbers, the sequence has {} images", factors->size(), n_images),
               "give a factor for each image, in the order of their numbers");
  return *factors;
}

}  // namespace

Room read_room(const TomlTable& root, const Twin& twin) {
  const auto table = root.table("room");
  if (!table) return {};
  table->allow(names_of_keys<Room>());
  Room room;
  if (const auto lamp = table->vector("lamp", 3, NumberRange::between(-kBrightestLamp, kBrightestLamp)))
    room.lamp_world = *lamp;
  if (room.has_lamp() && !twin.projector)
    table->fail("lamp", "has no effect without [projector]: without one nothing is rendered",
                "add [projector], or leave out [room]");
  return room;
}

void read_light_factors(const TomlTable& root, Twin& twin) {
  const std::size_t n = expand_sequence(twin.fringes).size();
  const NumberRange positive{.min = kSmallest, .max = kLargest}, or_none{.min = 0.0, .max = kLargest};
  const std::vector<TomlTable> cameras = root.tables("camera");
  for (std::size_t c = 0; c < twin.cameras.size(); ++c)
    twin.cameras[c].exposure_factors = read_factors(cameras.at(c), "exposure_factors", positive, n);
  if (!twin.projector) return;
  const TomlTable projector = *root.table("projector");
  twin.projector->light_factors = read_factors(projector, "light_factors", positive, n);
  twin.projector->ambient_factors = read_factors(projector, "ambient_factors", or_none, n);
  if (!twin.projector->ambient_factors.empty() && twin.projector->ambient == 0.0 && !twin.room.has_lamp())
    projector.fail("ambient_factors", "has no effect without ambient > 0 or [room] lamp");
}

}  // namespace fringetwin
