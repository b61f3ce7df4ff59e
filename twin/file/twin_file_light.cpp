// SPDX-License-Identifier: Apache-2.0
// Light of the room, and what each image of the sequence has of its own: [room], light_factors,
// ambient_factors, exposure_factors, image_shifts_px and [camera.timing] of twin.toml.
#include <fmt/format.h>

#include <algorithm>

#include "twin/file/plain_keys.hpp"
#include "twin/file/twin_file.hpp"

namespace fringetwin {
namespace {

/// A lamp that flickers, or an exposure that is not kept, stays well within this.
constexpr double kSmallest = 1e-3, kLargest = 1e3;
constexpr double kBrightestLamp = 1e9;
constexpr double kMostShiftPx = 1e4;

/// Returns the numbers of a key, none where it is left out. Refuses any other number of them than that of the
/// sequence's images.
std::vector<double> read_of_images(const TomlTable& table, const std::string& key, const NumberRange& range,
                                   std::size_t n_images, const char* each = "a factor") {
  const auto numbers = table.numbers(key, range);
  if (!numbers) return {};
  if (numbers->size() != n_images)
    table.fail(key, fmt::format("has {} numbers, the sequence has {} images", numbers->size(), n_images),
               fmt::format("give {} for each image, in the order of their numbers", each));
  return *numbers;
}

/// Shifts are those of patterns that run along an axis: not of images, nor of a raster, which stays.
void read_image_shifts(const TomlTable& table, Twin& twin) {
  static const std::string key = "image_shifts_px";
  const std::vector<PatternSpec> sequence = expand_sequence(twin.fringes);
  twin.projector->image_shifts_px = read_of_images(
      table, key, NumberRange::between(-kMostShiftPx, kMostShiftPx), sequence.size(), "a shift");
  if (!twin.projector->has_image_shifts()) return;
  if (twin.projector->pixel_structure)
    table.fail(key, "cannot be combined with pixel_structure: the raster of pixels stays where it is");
  for (std::size_t i = 0; i < sequence.size(); ++i)
    if (sequence[i].is_image() && twin.projector->image_shift_px(i) != 0.0)
      table.fail(key, fmt::format("moves image {}, which is a pattern image and runs along no axis", i),
                 "use 0");
}

/// Returns by how much each image is late, one number where all are alike. Refuses exposures that would see
/// more than the neighbouring patterns.
std::vector<double> read_late(const TomlTable& table, const ExposureTiming& timing, std::size_t n_images) {
  static const std::string key = "late";
  const NumberRange range = NumberRange::between(-1.0, 1.0);
  std::vector<double> late;
  if (table.has(key) && !table.is_array(key))
    late = {*table.number(key, range)};
  else
    late = read_of_images(table, key, range, n_images, "a number, or one number for all of them,");
  constexpr double kRounding = 1e-9;  // of decimal numbers
  const double reach = 0.5 * timing.read_out;
  for (std::size_t k = 0; k < std::max<std::size_t>(1, late.size()); ++k) {
    const double of_image = late.empty() ? 0.0 : late[k];
    const std::string image = late.size() > 1 ? fmt::format("image {}", k) : "an image";
    if (of_image - reach < -timing.exposure - kRounding)
      table.fail(key,
                 fmt::format("lets the exposure of {} end before its own pattern begins in some rows: it "
                             "begins {:.6g} before that",
                             image, reach - of_image),
                 fmt::format("keep late - read_out/2 >= -exposure = {}", -timing.exposure));
    if (of_image + reach > 1.0 + kRounding)
      table.fail(key,
                 fmt::format("lets the exposure of {} begin after its own pattern ends in some rows: "
                             "{:.6g} after that begins",
                             image, of_image + reach),
                 "keep late + read_out/2 <= 1");
  }
  return late;
}

/// A table without keys is none.
std::optional<ExposureTiming> read_timing(const TomlTable& camera, std::size_t n_images) {
  const auto table = camera.table("timing");
  if (!table) return std::nullopt;
  table->allow(names_of_keys<ExposureTiming>());
  if (table->keys().empty()) return std::nullopt;
  ExposureTiming timing;
  read_plain_keys(*table, timing);
  timing.late = read_late(*table, timing, n_images);
  return timing;
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
  for (std::size_t c = 0; c < twin.cameras.size(); ++c) {
    twin.cameras[c].exposure_factors = read_of_images(cameras.at(c), "exposure_factors", positive, n);
    twin.cameras[c].timing = read_timing(cameras.at(c), n);
  }
  if (!twin.projector) return;
  const TomlTable projector = *root.table("projector");
  twin.projector->light_factors = read_of_images(projector, "light_factors", positive, n);
  twin.projector->ambient_factors = read_of_images(projector, "ambient_factors", or_none, n);
  if (!twin.projector->ambient_factors.empty() && twin.projector->ambient == 0.0 && !twin.room.has_lamp())
    projector.fail("ambient_factors", "has no effect without ambient > 0 or [room] lamp");
  read_image_shifts(projector, twin);
}

}  // namespace fringetwin
