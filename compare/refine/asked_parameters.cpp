// SPDX-License-Identifier: Apache-2.0
#include "compare/refine/asked_parameters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "compare/causes/group_fit.hpp"
#include "compare/parameters/parameters.hpp"
#include "compare/refine/apply_texture.hpp"
#include "compare/refine/refine_guard.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/nearest_word.hpp"

namespace fringetwin::compare {
namespace {

/// What is fitted beside the parameters, or of each pixel.
bool is_no_parameter(const std::string& name) {
  return name == "gain" || name == "black" || name == "texture" || name == "offset" || name == kTextureSpread;
}

/// A device's or an object's name alone asks for all of it but these groups, and what no key holds.
constexpr std::array kByThemselves{"size",           "specular",        "intrinsics",      "motion",
                                   "timing",         "projector_field", "blur_field",      "camera_knee",
                                   "halo",           "camera_response", "harmonics_field", "harmonics_high",
                                   "subsurface",     "roughness",       "image_harmonics", "raster",
                                   "fringe_contrast"};

/// Returns the words that may be meant: groups, what is no parameter, and the names of the twin's parameters.
std::vector<std::string> words_for(const Twin& twin, const std::vector<int>& use_steps) {
  std::vector<std::string> words = {"texture", kTextureSpread, "offset", "gain", "black"};
  for (const ParameterGroup& group : parameter_groups()) {
    if (group.instead.empty()) words.push_back(group.name);
    for (const Parameter& p : refinable_parameters_of(twin, group.name, use_steps)) words.push_back(p.name);
  }
  return words;
}

/// The list of all words is longer than a sentence may be: the help has it.
[[noreturn]] void refuse_unknown(const std::string& word, const Twin& twin,
                                 const std::vector<int>& use_steps) {
  const std::string where = "--refine " + word;
  const auto& groups = parameter_groups();
  if (std::ranges::any_of(groups, [&](const auto& g) { return g.name == word; })) {
    const std::string absent = parameter_group(word).absent;
    throw UserError(ExitCode::usage, where, "the twin has no such parameter",
                    !absent.empty() ? absent : "leave it out; `fringetwin help cosim` lists the words");
  }
  const std::string near = did_you_mean(word, words_for(twin, use_steps));
  throw UserError(ExitCode::usage, where, "is not known",
                  (near.empty() ? "" : near + " ") +
                      "`fringetwin help cosim` lists the words, and a "
                      "parameter's own name (projector.k1) is one, too");
}

/// Refuses words that mean the same of the images, or need another word.
void refuse_what_stands_together(const Twin& twin, const std::vector<std::string>& asked,
                                 const std::vector<Parameter>& chosen) {
  const auto is_fitted = [&](const char* group) {
    return std::ranges::any_of(chosen, [=](const Parameter& p) { return p.group == group; });
  };
  const auto refuse = [](const std::string& why, const char* instead = "refine one of them") {
    throw UserError(ExitCode::usage, "--refine", why, instead);
  };
  const bool albedo = is_fitted("albedo"), texture = is_asked(asked, "texture");
  if (is_fitted("camera_knee") && is_fitted("camera_response"))
    refuse("camera_knee and camera_response are both the camera's curve, which is a knee or a table");
  if (albedo && texture) refuse("texture, a factor per pixel, contains the albedo of the objects");
  for (const char* group : {"vignetting", "projector_field"})
    if (texture && is_fitted(group))
      refuse(
          fmt::format("the images cannot tell {} and texture apart: a factor per pixel contains it", group));
  if (is_asked(asked, kTextureSpread) && !texture)
    refuse("texture_spread is told by the factors of neighbouring pixels, which nothing fits here",
           "add texture");
  if (is_asked(asked, kTextureSpread) && twin.fringes.steps == 0)
    refuse("texture_spread is told by smooth fringes, and a code has edges alone", "leave it out");
  if ((albedo || texture) && is_asked(asked, "gain"))
    refuse(fmt::format("gain and {} enter the gray values only as a product", texture ? "texture" : "albedo"),
           "refine one of them; the other stays at the twin's value");
  if ((is_fitted("contrast") || is_fitted("fringe_contrast")) && is_fitted("image_harmonics"))
    refuse("image_harmonics, a contrast of each image, contains the contrast of its pitch");
  if (texture && is_asked(asked, "offset") && is_fitted("fringe_contrast"))
    refuse("texture and offset, a factor and an offset per pixel, contain the contrast of all fringes",
           "leave fringe_contrast out; contrast is that of each pitch beside the widest");
  if (is_asked(asked, "offset") && is_asked(asked, "black"))
    refuse("an offset per pixel contains the black level: the images cannot tell them apart");
}

}  // namespace

bool is_asked_by(const std::string& asked, const Parameter& p) {
  if (p.name == asked) return true;
  if (p.only_by_name) return false;
  // what stands before ".motion" is the name of another parameter: where the object is
  if (p.group == "motion") return p.group == asked;
  const bool by_itself = std::ranges::find(kByThemselves, p.group) != kByThemselves.end() || !p.change;
  return p.group == asked ||
         (p.name.starts_with(asked + ".") && (!by_itself || asked.find('.') != std::string::npos));
}

bool is_asked(const std::vector<std::string>& asked, const char* word) {
  return std::ranges::find(asked, word) != asked.end();
}

bool asks_for_halo(const std::vector<std::string>& asked) {
  return std::ranges::any_of(
      asked, [](const std::string& a) { return a == "halo" || a.starts_with("projector.halo"); });
}

std::string refine_names() {
  std::string names;
  for (const ParameterGroup& group : parameter_groups())
    if (group.instead.empty()) names += group.name + ", ";
  return names + "texture, texture_spread, offset, gain, black";
}

std::vector<Parameter> chosen_parameters(const Twin& twin, const std::vector<std::string>& asked,
                                         const std::vector<int>& use_steps) {
  std::vector<Parameter> chosen;
  std::vector<bool> met(asked.size(), false);
  for (const ParameterGroup& group : parameter_groups())
    for (Parameter& p : refinable_parameters_of(twin, group.name, use_steps)) {
      bool wanted = false;
      for (std::size_t i = 0; i < asked.size(); ++i)
        if (is_asked_by(asked[i], p)) wanted = met[i] = true;
      if (wanted && !p.instead.empty())
        throw UserError(ExitCode::usage, "--refine", "no key of twin.toml holds " + p.name, p.instead);
      if (wanted) chosen.push_back(std::move(p));
    }
  for (std::size_t i = 0; i < asked.size(); ++i)
    if (!met[i] && !is_no_parameter(asked[i])) refuse_unknown(asked[i], twin, use_steps);
  if (std::ranges::any_of(chosen, [](const Parameter& p) { return p.group == "timing"; }))
    make_ready_for_timing(twin, chosen);
  refuse_what_stands_together(twin, asked, chosen);
  return chosen;
}

std::vector<Parameter> refinable_parameters(const Twin& twin, const std::vector<std::string>& asked,
                                            const std::vector<int>& use_steps) {
  if (!asked.empty())
    return chosen_parameters(asks_for_halo(asked) ? with_empty_halo(twin) : twin, asked, use_steps);
  std::vector<Parameter> all;
  for (const ParameterGroup& group : parameter_groups())
    for (Parameter& p : refinable_parameters_of(twin, group.name, use_steps)) all.push_back(std::move(p));
  return all;
}

bool asks_for_places(const Twin& twin, const std::vector<std::string>& asked,
                     const std::vector<int>& use_steps) {
  return std::ranges::any_of(refinable_parameters(twin, asked, use_steps),
                             [](const Parameter& p) { return is_geometric(p.group); });
}

void check_refine(const Twin& twin, const std::vector<std::string>& asked) {
  chosen_parameters(asks_for_halo(asked) ? with_empty_halo(twin) : twin, asked);
}

}  // namespace fringetwin::compare
