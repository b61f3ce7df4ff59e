// SPDX-License-Identifier: Apache-2.0
// A refined twin's new values in the words of twin.toml.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "compare/causes/parameters_geometry.hpp"
#include "compare/causes/refine.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/moving.hpp"

namespace fringetwin::compare {
namespace {

std::string numbers(const std::vector<double>& values) {
  return fmt::format("[{}]", fmt::join(values, ", "));  // shortest, exact
}
std::string numbers(const Pose& pose) {
  const RotTrans rt = rt_from_pose(pose);
  return numbers(std::vector<double>(rt.data(), rt.data() + 6));
}

/// Writes the lines of one table; nothing where none of its keys changed.
class TableText {
 public:
  explicit TableText(std::string head) : head_(std::move(head)) {}
  void key(const std::string& name, const std::string& before, const std::string& after) {
    if (before != after) lines_ += fmt::format("{} = {}\n", name, after);
  }
  std::string text() const { return lines_.empty() ? "" : head_ + "\n" + lines_ + "\n"; }

 private:
  std::string head_, lines_;
};

std::string response_text(const ProjectorResponse& r) {
  if (r.kind == ProjectorResponse::Kind::gamma) return fmt::format("{{ gamma = {} }}", r.gamma);
  if (r.kind == ProjectorResponse::Kind::table) return "{ table = " + numbers(r.table) + " }";
  return "\"linear\"";
}

std::string camera_text(const Camera& before, const Camera& after) {
  TableText t("[[camera]]  # \"" + after.name + "\"");
  t.key("lensmodel", "\"" + before.lens.model() + "\"", "\"" + after.lens.model() + "\"");
  t.key("intrinsics", numbers(before.lens.intrinsics()), numbers(after.lens.intrinsics()));
  t.key("rt_cam_world", numbers(before.T_cam_world), numbers(after.T_cam_world));
  const auto polynomial = [](const Camera& c) {
    return numbers(std::vector<double>(c.vignetting.a.begin(), c.vignetting.a.end()));
  };
  const auto tilt = [](const Camera& c) {
    return numbers(std::vector<double>(c.vignetting.tilt.begin(), c.vignetting.tilt.end()));
  };
  t.key("exposure_factors", numbers(before.exposure_factors), numbers(after.exposure_factors));
  t.key("texture", fmt::format("\"{}\"", plain_text(before.texture_file.string())),
        fmt::format("\"{}\"", plain_text(after.texture_file.string())));
  t.key("vignetting", polynomial(before), polynomial(after));
  t.key("vignetting_tilt", tilt(before), tilt(after));
  TableText sensor("[camera.sensor]  # \"" + after.name + "\"");
  sensor.key("gain_dn", fmt::format("{}", before.sensor.gain_dn), fmt::format("{}", after.sensor.gain_dn));
  sensor.key("black_level_dn", fmt::format("{}", before.sensor.black_level_dn),
             fmt::format("{}", after.sensor.black_level_dn));
  return t.text() + sensor.text();
}

std::string projector_text(const Projector& before, const Projector& after) {
  TableText t("[projector]");
  t.key("lensmodel", "\"" + before.lens.model() + "\"", "\"" + after.lens.model() + "\"");
  t.key("intrinsics", numbers(before.lens.intrinsics()), numbers(after.lens.intrinsics()));
  t.key("rt_cam_world", numbers(before.T_proj_world), numbers(after.T_proj_world));
  t.key("blur_px", fmt::format("{}", before.blur_px), fmt::format("{}", after.blur_px));
  t.key("response", response_text(before.response), response_text(after.response));
  t.key("light_factors", numbers(before.light_factors), numbers(after.light_factors));
  return t.text();
}

std::string harmonics_text(const Harmonics& list) {
  std::vector<std::string> pairs;
  for (const Harmonic& h : list) pairs.push_back(numbers(std::vector<double>{h.cosine, h.sine}));
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

std::vector<double> contrasts(const DirectionFringes& direction) {
  std::vector<double> all;
  for (std::size_t p = 0; p < direction.pitches_px.size(); ++p) all.push_back(direction.contrast_of(p));
  return all;
}

/// The keys of each direction that differ: they win over those of [fringes].
std::string fringes_text(const Fringes& before, const Fringes& after) {
  std::string text;
  for (std::size_t d = 0; d < after.directions.size(); ++d) {
    const DirectionFringes &now = after.directions[d], &then = before.directions[d];
    TableText t(fmt::format("[fringes.{}]", axis_name(now.axis)));
    t.key("harmonics", harmonics_text(then), harmonics_text(now));
    t.key("contrast", numbers(contrasts(then)), numbers(contrasts(now)));
    text += t.text();
  }
  return text;
}

std::string object_text(const Object& before, const Object& after) {
  TableText t("[[object]]  # \"" + after.name + "\"");
  std::visit(
      [&]<class S>(const S& shape) {
        const std::vector<PlaceKey> old = place_keys(std::get<S>(before.shape)), now = place_keys(shape);
        for (std::size_t i = 0; i < now.size(); ++i)
          t.key(now[i].key, numbers(old.at(i).values), numbers(now[i].values));
      },
      after.shape);
  const std::vector<PlaceKey> old_size = size_keys(before.shape), size = size_keys(after.shape);
  for (std::size_t i = 0; i < size.size(); ++i)
    t.key(size[i].key, fmt::format("{}", old_size.at(i).values[0]), fmt::format("{}", size[i].values[0]));
  t.key("motion", motion_text(before), motion_text(after));
  TableText material("[object.material]  # \"" + after.name + "\"");
  material.key("diffuse", fmt::format("{}", before.material.diffuse),
               fmt::format("{}", after.material.diffuse));
  material.key("specular", fmt::format("{}", before.material.specular),
               fmt::format("{}", after.material.specular));
  return t.text() + material.text();
}

}  // namespace

std::string refined_toml(const Refinement& r, const Twin& before, const Twin& after) {
  std::string text = fmt::format("# Refined from {} (--refine {}): chi2 per gray value {:.5g} -> {:.5g}{}.\n",
                                 plain_text(before.file.string()), fmt::join(r.asked, ","), r.chi2_before,
                                 r.chi2_after, r.converged ? "" : ", NOT CONVERGED");
  for (const RefinedRow& row : r.rows)
    text += fmt::format("#   {}: {:.10g} -> {:.10g} {}, standard error {:.2g}\n", row.name, row.before,
                        row.after, row.unit, row.sigma);
  text += "# Keys to replace in the twin's tables:\n\n";
  for (std::size_t c = 0; c < after.cameras.size(); ++c)
    text += camera_text(before.cameras[c], after.cameras[c]);
  if (after.projector) text += projector_text(*before.projector, *after.projector);
  text += fringes_text(before.fringes, after.fringes);
  for (std::size_t k = 0; k < after.objects.size(); ++k)
    text += object_text(before.objects[k], after.objects[k]);
  TableText render("[render]");
  render.key("bounces", fmt::format("{}", before.render.bounces), fmt::format("{}", after.render.bounces));
  return text + render.text();
}

}  // namespace fringetwin::compare
