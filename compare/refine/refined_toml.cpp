// SPDX-License-Identifier: Apache-2.0
// A refined twin's new values in the words of twin.toml.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "compare/parameters/parameters_geometry.hpp"
#include "compare/refine/refine.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/moving.hpp"

namespace fringetwin::compare {
namespace {

std::string numbers(std::span<const double> values) {
  return fmt::format("[{}]", fmt::join(values, ", "));  // shortest, exact
}
std::string numbers(const Pose& pose) {
  const RotTrans rt = rt_from_pose(pose);
  return numbers({rt.data(), 6});
}

/// Collects the keys of one table that changed.
class ChangedKeys {
 public:
  explicit ChangedKeys(TomlBlock block) : block_(std::move(block)) {}
  void key(const std::string& name, const std::string& before, const std::string& after) {
    if (before != after) block_.keys.push_back({name, after});
  }
  bool has(const std::string& name) const {
    return std::ranges::find(block_.keys, name, &TomlKey::name) != block_.keys.end();
  }
  /// Where the file has these keys, it needs those instead.
  void exclude(std::vector<std::string> keys, std::vector<TomlKey> instead,
               std::vector<std::string> also = {}) {
    block_.exclusions.push_back({std::move(keys), std::move(instead), std::move(also)});
  }
  void append_to(std::vector<TomlBlock>& blocks) const {
    if (!block_.keys.empty()) blocks.push_back(block_);
  }

 private:
  TomlBlock block_;
};

std::string quoted(const std::string& text) { return "\"" + text + "\""; }

/// Lens and pose of a camera or the projector. A file may have them from elsewhere, as whole.
void add_device(ChangedKeys& keys, const Lens& lens_before, const Pose& pose_before, const Lens& lens,
                const Pose& pose) {
  keys.key("lensmodel", quoted(lens_before.model()), quoted(lens.model()));
  keys.key("intrinsics", numbers(lens_before.intrinsics()), numbers(lens.intrinsics()));
  keys.key("rt_cam_world", numbers(pose_before), numbers(pose));
  const std::vector<std::string> other_poses{"position_mm", "look_at_mm", "up", "baseline_mm", "angle_deg"};
  if (keys.has("lensmodel") || keys.has("intrinsics") || keys.has("rt_cam_world"))
    keys.exclude({"model", "opencv"},
                 {{"lensmodel", quoted(lens.model())},
                  {"imagersize", fmt::format("[{}, {}]", lens.width(), lens.height())},
                  {"intrinsics", numbers(lens.intrinsics())},
                  {"rt_cam_world", numbers(pose)}},
                 other_poses);
  if (keys.has("rt_cam_world")) keys.exclude(other_poses, {});
}

std::string response_text(const ProjectorResponse& r) {
  if (r.kind == ProjectorResponse::Kind::gamma) return fmt::format("{{ gamma = {} }}", r.gamma);
  if (r.kind == ProjectorResponse::Kind::table) return "{ table = " + numbers(r.table) + " }";
  return "\"linear\"";
}

std::string response_text(const CameraResponse& r) {
  if (r.straight()) return "\"linear\"";
  if (r.corners.size() == 1)
    return fmt::format("{{ knee_dn = {}, slope = {} }}", r.corners[0].in_dn, r.last_slope);
  std::vector<std::string> points;
  for (const CameraResponse::Corner& c : r.corners) points.push_back(numbers(std::array{c.in_dn, c.out_dn}));
  return fmt::format("{{ table = [{}] }}", fmt::join(points, ", "));
}

/// A number where all images are alike, else one per image.
std::string late_text(const ExposureTiming& timing) {
  if (std::ranges::all_of(timing.late, [&](double late) { return late == timing.late.front(); }))
    return fmt::format("{}", timing.late_of(0));
  return numbers(timing.late);
}

void add_camera(std::vector<TomlBlock>& blocks, const Camera& before, const Camera& after) {
  ChangedKeys camera({.table = {"camera"}, .entry = after.name});
  add_device(camera, before.whole_lens(), before.T_cam_world, after.whole_lens(), after.T_cam_world);
  camera.key("exposure_factors", numbers(before.exposure_factors), numbers(after.exposure_factors));
  camera.key("texture", quoted(plain_text(before.texture_file.string())),
             quoted(plain_text(after.texture_file.string())));
  camera.key("texture_spread_px", fmt::format("{}", before.texture_spread_px),
             fmt::format("{}", after.texture_spread_px));
  camera.key("vignetting", numbers(before.vignetting.a), numbers(after.vignetting.a));
  camera.key("vignetting_tilt", numbers(before.vignetting.tilt), numbers(after.vignetting.tilt));
  camera.append_to(blocks);
  ChangedKeys sensor({.table = {"camera", "sensor"}, .entry = after.name});
  sensor.key("gain_dn", fmt::format("{}", before.sensor.gain_dn), fmt::format("{}", after.sensor.gain_dn));
  sensor.key("black_level_dn", fmt::format("{}", before.sensor.black_level_dn),
             fmt::format("{}", after.sensor.black_level_dn));
  sensor.key("response", response_text(before.sensor.response), response_text(after.sensor.response));
  sensor.append_to(blocks);
  const ExposureTiming then = before.timing.value_or(ExposureTiming{}),
                       now = after.timing.value_or(ExposureTiming{});
  ChangedKeys timing({.table = {"camera", "timing"}, .entry = after.name});
  timing.key("read_out", fmt::format("{}", then.read_out), fmt::format("{}", now.read_out));
  timing.key("late", late_text(then), late_text(now));
  timing.append_to(blocks);
}

std::string halo_text(const std::vector<Halo>& halo) {
  std::vector<std::string> parts;
  for (const Halo& h : halo) parts.push_back(numbers(std::array{h.share, h.sigma_px}));
  return fmt::format("[{}]", fmt::join(parts, ", "));
}

void add_projector(std::vector<TomlBlock>& blocks, const Projector& before, const Projector& after) {
  ChangedKeys keys({.table = {"projector"}});
  add_device(keys, before.lens, before.T_proj_world, after.lens, after.T_proj_world);
  keys.key("intensity", fmt::format("{}", before.intensity), fmt::format("{}", after.intensity));
  keys.key("blur_px", fmt::format("{}", before.blur_px), fmt::format("{}", after.blur_px));
  keys.key("blur_field_px2", numbers(before.blur_field_px2), numbers(after.blur_field_px2));
  keys.key("halo", halo_text(before.halo), halo_text(after.halo));
  keys.key("response", response_text(before.response), response_text(after.response));
  keys.key("light_field", numbers(before.light_field), numbers(after.light_field));
  keys.key("light_factors", numbers(before.light_factors), numbers(after.light_factors));
  keys.key("image_shifts_px", numbers(before.image_shifts_px), numbers(after.image_shifts_px));
  keys.append_to(blocks);
}

std::string harmonics_text(const Harmonics& list) {
  std::vector<std::string> pairs;
  for (const Harmonic& h : list) pairs.push_back(numbers(std::array{h.cosine, h.sine}));
  return fmt::format("[{}]", fmt::join(pairs, ", "));
}
/// One list of pairs where all pitches have the same, else one per pitch.
std::string harmonics_text(const DirectionFringes& direction) {
  std::vector<std::string> lists;
  for (std::size_t p = 0; p < direction.pitches_px.size(); ++p)
    lists.push_back(harmonics_text(direction.harmonics_of(p)));
  if (std::ranges::count(lists, lists.front()) == std::ssize(lists)) return lists.front();
  return fmt::format("[{}]", fmt::join(lists, ", "));
}

std::string lists_text(const std::vector<Harmonics>& all) {
  std::vector<std::string> lists;
  for (const Harmonics& list : all) lists.push_back(harmonics_text(list));
  return fmt::format("[{}]", fmt::join(lists, ", "));
}

std::string raster_text(const Raster& raster) {
  return fmt::format("{{ pitch_px = {}, first = {}, waves = {} }}", raster.pitch_px, raster.first_order,
                     harmonics_text(raster.waves));
}

std::vector<double> contrasts(const DirectionFringes& direction) {
  std::vector<double> all;
  for (std::size_t p = 0; p < direction.pitches_px.size(); ++p) all.push_back(direction.contrast_of(p));
  return all;
}

/// The keys of each direction that differ (they win over those of [fringes]), and those of single images.
void add_fringes(std::vector<TomlBlock>& blocks, const Fringes& before, const Fringes& after) {
  for (std::size_t d = 0; d < after.directions.size(); ++d) {
    const DirectionFringes &now = after.directions[d], &then = before.directions[d];
    ChangedKeys keys({.table = {"fringes", axis_name(now.axis)}});
    keys.key("harmonics", harmonics_text(then), harmonics_text(now));
    keys.key("harmonics_field", lists_text(then.harmonics_field), lists_text(now.harmonics_field));
    keys.key("raster", raster_text(then.raster), raster_text(now.raster));
    keys.key("contrast", numbers(contrasts(then)), numbers(contrasts(now)));
    keys.append_to(blocks);
  }
  ChangedKeys keys({.table = {"fringes"}});
  keys.key("image_harmonics", lists_text(before.image_harmonics), lists_text(after.image_harmonics));
  keys.append_to(blocks);
}

/// Returns whether two vectors are one but for rounding, as that of making it one of unit length again.
bool is_same_place(std::span<const double> a, std::span<const double> b) {
  constexpr double kRounding = 1e-15;
  if (a.size() != b.size()) return false;
  double size = 0.0, apart = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    size = std::max({size, std::abs(a[i]), std::abs(b[i])});
    apart = std::max(apart, std::abs(a[i] - b[i]));
  }
  return apart <= kRounding * size;
}

void add_object(std::vector<TomlBlock>& blocks, const Object& before, const Object& after) {
  ChangedKeys object({.table = {"object"}, .entry = after.name});
  std::visit(
      [&]<class S>(const S& shape) {
        const std::vector<PlaceKey> old = place_keys(std::get<S>(before.shape)), now = place_keys(shape);
        for (std::size_t i = 0; i < now.size(); ++i)
          if (!is_same_place(old.at(i).values, now[i].values))
            object.key(now[i].key, numbers(old.at(i).values), numbers(now[i].values));
      },
      after.shape);
  const std::vector<PlaceKey> old_size = size_keys(before.shape), size = size_keys(after.shape);
  for (std::size_t i = 0; i < size.size(); ++i)
    object.key(size[i].key, fmt::format("{}", old_size.at(i).values[0]),
               fmt::format("{}", size[i].values[0]));
  object.key("motion", motion_text(before), motion_text(after));
  object.append_to(blocks);
  ChangedKeys material({.table = {"object", "material"}, .entry = after.name});
  material.key("diffuse", fmt::format("{}", before.material.diffuse),
               fmt::format("{}", after.material.diffuse));
  material.key("specular", fmt::format("{}", before.material.specular),
               fmt::format("{}", after.material.specular));
  material.key("roughness", fmt::format("{}", before.material.roughness),
               fmt::format("{}", after.material.roughness));
  material.key("shininess", fmt::format("{}", before.material.shininess),
               fmt::format("{}", after.material.shininess));
  material.key("mean_free_path_mm", fmt::format("{}", before.material.mean_free_path_mm),
               fmt::format("{}", after.material.mean_free_path_mm));
  material.append_to(blocks);
}

/// Returns "[camera.sensor]  # \"left\"" with the keys below it.
std::string text_of(const TomlBlock& block) {
  const bool is_list = block.table.size() == 1 && !block.entry.empty();
  std::string text = fmt::format("[{}]", fmt::join(block.table, "."));
  if (is_list) text = "[" + text + "]";
  if (!block.entry.empty()) text += "  # " + quoted(block.entry);
  text += "\n";
  for (const TomlKey& key : block.keys) text += fmt::format("{} = {}\n", key.name, key.value);
  return text + "\n";
}

}  // namespace

std::vector<TomlBlock> refined_blocks(const Twin& before, const Twin& after) {
  std::vector<TomlBlock> blocks;
  for (std::size_t c = 0; c < after.cameras.size(); ++c)
    add_camera(blocks, before.cameras[c], after.cameras[c]);
  if (after.projector) add_projector(blocks, *before.projector, *after.projector);
  add_fringes(blocks, before.fringes, after.fringes);
  for (std::size_t k = 0; k < after.objects.size(); ++k)
    add_object(blocks, before.objects[k], after.objects[k]);
  ChangedKeys room({.table = {"room"}});
  const auto lamp = [](const Twin& t) {
    return numbers(std::vector<double>(t.room.lamp_world.begin(), t.room.lamp_world.end()));
  };
  room.key("lamp", lamp(before), lamp(after));
  room.append_to(blocks);
  ChangedKeys render({.table = {"render"}, .may_be_new = true});
  const auto bounces = [](const Twin& t) {
    return t.render.bounces >= kAllBounces ? std::string("\"all\"") : fmt::format("{}", t.render.bounces);
  };
  render.key("bounces", bounces(before), bounces(after));
  render.key("glossy_bounces", fmt::format("{}", before.render.glossy_bounces),
             fmt::format("{}", after.render.glossy_bounces));
  render.append_to(blocks);
  return blocks;
}

std::vector<TomlBlock> refinable_tables(const Twin& twin) {
  std::vector<TomlBlock> tables;
  for (const Camera& camera : twin.cameras)
    for (const char* table : {"sensor", "timing"})
      tables.push_back({.table = {"camera", table}, .entry = camera.name});
  if (twin.projector) tables.push_back({.table = {"projector"}});
  for (const DirectionFringes& direction : twin.fringes.directions)
    tables.push_back({.table = {"fringes", axis_name(direction.axis)}});
  if (twin.room.has_lamp()) tables.push_back({.table = {"room"}});
  for (const Object& object : twin.objects)
    tables.push_back({.table = {"object", "material"}, .entry = object.name});
  return tables;
}

std::string refined_toml(const Refinement& r, const Twin& before, const Twin& after) {
  std::string text = fmt::format("# Refined from {} (--refine {}): chi2 per gray value {:.5g} -> {:.5g}{}.\n",
                                 plain_text(before.file.string()), fmt::join(r.asked, ","), r.chi2_before,
                                 r.chi2_after, r.converged ? "" : ", NOT CONVERGED");
  for (const RefinedRow& row : r.rows)
    text += fmt::format("#   {}: {:.10g} -> {:.10g} {}, standard error {:.2g}\n", row.name, row.before,
                        row.after, row.unit, row.sigma);
  text += "# Keys to replace in the twin's tables (`--into twin.toml` does so):\n\n";
  for (const TomlBlock& block : refined_blocks(before, after)) text += text_of(block);
  return text;
}

}  // namespace fringetwin::compare
