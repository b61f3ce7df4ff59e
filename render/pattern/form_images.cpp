// SPDX-License-Identifier: Apache-2.0
#include "render/pattern/form_images.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <set>
#include <span>
#include <utility>

#include "render/pattern/camera_effects.hpp"
#include "render/pattern/formed_harmonics.hpp"
#include "render/pattern/raster_waves.hpp"
#include "render/pattern/response_series.hpp"
#include "render/pattern/transport_images.hpp"
#include "render/pattern/waveform.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

// All images are formed for so many pixels at a time: what they read in common then stays in the cache.
constexpr std::ptrdiff_t kPixelsAtATime = 8192;
constexpr std::ptrdiff_t kFormedAtATime = 512;  // with their harmonics

struct Term {
  const float *cosine, *sine;  ///< nullptr: formed
  float c, s;
  std::vector<std::array<float, 2>> of_field = {};  ///< what c and s have more per term of a field
};

// What an image has of the projector's light and of the ambient light, over what all images have.
struct LightOfImage {
  double projector = 1.0, ambient = 1.0;
};

// Returns the factors of all images; empty where each is 1.
std::vector<LightOfImage> light_of_images(const Twin& twin, const Camera& camera, std::size_t n_images) {
  const Projector& projector = *twin.projector;
  const std::vector<double>* lists[] = {&projector.light_factors, &projector.ambient_factors,
                                        &camera.exposure_factors};
  if (std::ranges::all_of(lists, [](const auto* list) { return list->empty(); })) return {};
  for (const auto* list : lists)
    FT_CHECK(list->empty() || list->size() == n_images, "a factor for each image of the sequence");
  std::vector<LightOfImage> out;
  for (std::size_t i = 0; i < n_images; ++i) {
    const double exposure = factor_of(camera.exposure_factors, i);
    out.push_back({exposure * factor_of(projector.light_factors, i),
                   exposure * factor_of(projector.ambient_factors, i)});
  }
  return out;
}

// Describes one image as a sum over arrays of the transport.
struct Recipe {
  float* out = nullptr;
  const float* direct = nullptr;  ///< instead of all others
  float level = 0.0F;
  std::vector<Term> terms, waves;
  std::size_t direction = 0, pitch = 0;
  float of_direct = 1.0F, of_ambient = 1.0F;  ///< LightOfImage; the level and the terms hold theirs
};

// Returns whether the harmonics of a pitch are formed from its fundamental.
bool is_formed(const Transport& transport, std::size_t direction, std::size_t pitch) {
  return transport.series[direction][pitch].a.size() > 2 && transport.harmonics[direction][pitch].empty();
}

// Returns the terms of the waves of the raster that an image has.
std::vector<Term> make_waves(const Twin& twin, const Transport& transport, const PatternSpec& spec,
                             std::size_t index, double light) {
  std::vector<Term> terms;
  if (transport.waves.empty() || spec.kind != PatternSpec::Kind::phase_step) return terms;
  for (const WaveTerm& term : waves_of_image(twin, spec, index)) {
    const Transport::Pair& sums =
        transport
            .waves[static_cast<std::size_t>(spec.direction)][static_cast<std::size_t>(spec.pitch)][term.wave];
    terms.push_back({sums.cosine.data.data(), sums.sine.data.data(), static_cast<float>(light * term.cosine),
                     static_cast<float>(light * term.sine)});
  }
  return terms;
}

// Returns the recipe of an image of the sequence; its `out` is still to be set.
Recipe make_recipe(const Twin& twin, const Transport& transport, const PatternSpec& spec, std::size_t index,
                   const LightOfImage& light) {
  Recipe recipe;
  recipe.of_direct = static_cast<float>(light.projector);
  recipe.of_ambient = static_cast<float>(light.ambient);
  recipe.waves = make_waves(twin, transport, spec, index, light.projector);
  if (index < transport.direct.size() && !transport.direct[index].empty()) {
    recipe.direct = transport.direct[index].data.data();
    return recipe;
  }
  FT_CHECK(!spec.is_gray() && !transport.cosine.empty(), "transport without the image's sums");
  const auto d = static_cast<std::size_t>(spec.direction), p = static_cast<std::size_t>(spec.pitch);
  const double pitch_px = twin.fringes.directions[d].pitches_px[p];
  const double delta = kTwoPi * (static_cast<double>(spec.step) / twin.fringes.steps -
                                 twin.projector->image_shift_px(index) / pitch_px);
  const PhaseSeries series = series_of_image(twin, transport.series[d][p], spec, index);
  const std::vector<double>& a = series.a;
  FT_CHECK(a.size() >= 2, "a response has a mean and a fundamental");
  recipe.level = static_cast<float>(light.projector * a[0]);
  recipe.direction = d;
  recipe.pitch = p;
  const bool formed = is_formed(transport, d, p);
  for (std::size_t h = 1; h < a.size(); ++h) {
    const float *cosine = nullptr, *sine = nullptr;
    if (h == 1) {
      cosine = transport.cosine[d][p].data.data();
      sine = transport.sine[d][p].data.data();
    } else if (!formed) {
      cosine = transport.harmonics[d][p][h - 2].cosine.data.data();
      sine = transport.harmonics[d][p][h - 2].sine.data.data();
    }
    const double c = std::cos(static_cast<double>(h) * delta), s = std::sin(static_cast<double>(h) * delta);
    const auto turned = [&](const PhaseSeries& of) {
      const double even = light.projector * of.a[h], odd = light.projector * of.sine(h);
      return std::array{static_cast<float>(even * c + odd * s), static_cast<float>(even * s - odd * c)};
    };
    const auto [on_cosine, on_sine] = turned(series);
    recipe.terms.push_back({cosine, sine, on_cosine, on_sine});
    if (h == 1 || transport.series_of_field.empty()) continue;
    for (const PhaseSeries& of_term : transport.series_of_field[d][p])
      recipe.terms.back().of_field.push_back(turned(of_term));
  }
  return recipe;
}

// Returns true where no light of any kind arrives: the images stay 0 there. (Where the mean is 0, every
// pattern is 0.)
bool all_dark(const Transport& transport, std::ptrdiff_t first, std::ptrdiff_t end) {
  const auto dark = [&](const ImageF& image) {
    return std::all_of(image.data.begin() + first, image.data.begin() + end,
                       [](float v) { return v == 0.0F; });
  };
  return dark(transport.mean) && dark(transport.ambient);
}

// Leaves out what is dark at either end of some pixels.
void trim_dark(const Transport& transport, std::ptrdiff_t* first, std::ptrdiff_t* end) {
  const float *mean = transport.mean.data.data(), *ambient = transport.ambient.data.data();
  const auto dark = [&](std::ptrdiff_t k) { return mean[k] == 0.0F && ambient[k] == 0.0F; };
  while (*first < *end && dark(*first)) ++*first;
  while (*end > *first && dark(*end - 1)) --*end;
}

// Adds what a harmonic has more at the places that light these pixels.
void add_of_field(const Term& term, const Transport& transport, const float* cosine, const float* sine,
                  std::ptrdiff_t first, std::ptrdiff_t end, float* out) {
  for (std::size_t t = 0; t < term.of_field.size(); ++t) {
    const auto [c, s] = term.of_field[t];
    if (c == 0.0F && s == 0.0F) continue;
    const float* size = transport.field_terms[t].data.data();
    for (std::ptrdiff_t k = first; k < end; ++k)
      out[k] += size[k] * (c * cosine[k - first] - s * sine[k - first]);
  }
}

void add_pair(const Term& term, std::ptrdiff_t first, std::ptrdiff_t end, float* out) {
  for (std::ptrdiff_t k = first; k < end; ++k) out[k] += term.c * term.cosine[k] - term.s * term.sine[k];
}

// Forms the pixels first ... end - 1 of one image but for the waves of the raster. `formed`: the pairs of its
// pitch for these pixels, if any.
void follow(const Recipe& recipe, const Transport& transport, std::span<const FormedPair> formed,
            std::ptrdiff_t first, std::ptrdiff_t end) {
  const float *ambient = transport.ambient.data.data(), *mean = transport.mean.data.data();
  float* out = recipe.out;
  if (recipe.direct) {
    for (std::ptrdiff_t k = first; k < end; ++k) out[k] = ambient[k] + recipe.direct[k];
    return;
  }
  const Term& one = recipe.terms.front();
  const float level = recipe.level;
  for (std::ptrdiff_t k = first; k < end; ++k)
    out[k] = ambient[k] + level * mean[k] + one.c * one.cosine[k] - one.s * one.sine[k];
  for (std::size_t h = 1; h < recipe.terms.size(); ++h) {
    const Term& term = recipe.terms[h];
    if (formed.empty()) {
      add_pair(term, first, end, out);
      add_of_field(term, transport, term.cosine + first, term.sine + first, first, end, out);
    } else {
      add_formed(formed[h - 1], term.c, term.s, end - first, out + first);
      add_of_field(term, transport, formed[h - 1].cosine, formed[h - 1].sine, first, end, out);
    }
  }
}

// Holds the formed pairs of one pitch for a few pixels at a time.
class FormedPairs {
 public:
  std::span<const FormedPair> of(const Twin& twin, const Transport& transport, const Recipe& recipe,
                                 std::ptrdiff_t first, std::ptrdiff_t end) {
    const std::size_t d = recipe.direction, p = recipe.pitch;
    if (recipe.direct || !is_formed(transport, d, p)) return {};
    if (d == direction_ && p == pitch_ && first == first_) return pairs_;
    const std::size_t n_pairs = transport.series[d][p].a.size() - 2;
    values_.resize(2 * n_pairs * kFormedAtATime);
    pairs_.clear();
    for (std::size_t i = 0; i < n_pairs; ++i)
      pairs_.push_back({&values_[2 * i * kFormedAtATime], &values_[(2 * i + 1) * kFormedAtATime]});
    form_harmonics(transport, d, p, twin.fringes.directions[d].pitches_px[p], twin.projector->blur_px, first,
                   end - first, pairs_);
    direction_ = d;
    pitch_ = p;
    first_ = first;
    return pairs_;
  }

 private:
  std::size_t direction_ = 0, pitch_ = 0;
  std::ptrdiff_t first_ = -1;
  std::vector<float> values_;
  std::vector<FormedPair> pairs_;
};

// Gives the pixels of one image its own light, besides what the level and the terms hold.
void light_up(const Recipe& recipe, const Transport& transport, std::ptrdiff_t first, std::ptrdiff_t end) {
  const float more_ambient = recipe.of_ambient - 1.0F, more_direct = recipe.of_direct - 1.0F;
  if (recipe.direct && more_direct != 0.0F)
    for (std::ptrdiff_t k = first; k < end; ++k) recipe.out[k] += more_direct * recipe.direct[k];
  if (more_ambient != 0.0F)
    for (std::ptrdiff_t k = first; k < end; ++k)
      recipe.out[k] += more_ambient * transport.ambient.data[static_cast<std::size_t>(k)];
}

Twin without_exposures(const Twin& twin, std::size_t camera_index) {
  Twin out = twin;
  out.cameras[camera_index].exposure_factors.clear();
  return out;
}

// Adds images under a projector that is all bright, and all dark.
void add_references(const Twin& twin, const Transport& transport, RenderedCamera& out) {
  const auto level = [&](double value) {
    const auto factor = static_cast<float>(twin.projector->response(value));
    ImageF even = transport.ambient;
    for (std::size_t i = 0; i < even.size(); ++i) even.data[i] += factor * transport.mean.data[i];
    return even;
  };
  out.white = level(1.0);
  out.black = level(0.0);
}

// Returns the recipes of images of the sequence; with `asked` only of those, the others' are empty.
std::vector<Recipe> make_recipes(const Twin& twin, std::size_t camera_index, const Transport& transport,
                                 ImageRange range, const std::vector<bool>& asked = {}) {
  const std::vector<PatternSpec> sequence = expand_sequence(twin.fringes);
  const std::vector<LightOfImage> light =
      light_of_images(twin, twin.cameras.at(camera_index), sequence.size());
  std::vector<Recipe> recipes;
  for (std::size_t i = range.first; i < range.first + range.count; ++i)
    recipes.push_back(asked.empty() || asked[i] ? make_recipe(twin, transport, sequence.at(i), i,
                                                              light.empty() ? LightOfImage{} : light[i])
                                                : Recipe{});
  return recipes;
}

// Returns which images are sums of four images of the transport and no more; empty where keeping them as such
// sums takes hardly less memory.
std::vector<bool> plain_sums(const Twin& twin, std::size_t camera_index, const Transport& transport) {
  const std::size_t n_images = expand_sequence(twin.fringes).size();
  std::vector<bool> sums;
  std::set<const float*> sources{transport.mean.data.data(), transport.ambient.data.data()};
  for (const Recipe& recipe : make_recipes(twin, camera_index, transport, {0, n_images})) {
    sums.push_back(!recipe.direct && recipe.terms.size() == 1 && recipe.waves.empty());
    if (sums.back()) sources.insert({recipe.terms.front().cosine, recipe.terms.front().sine});
  }
  const auto n_sums = static_cast<std::size_t>(std::ranges::count(sums, true));
  return n_sums >= 2 * sources.size() ? sums : std::vector<bool>();
}

// Drops what plain sums do not need.
Transport only_sums(Transport transport) {
  transport.harmonics.clear();
  transport.own_harmonics.clear();
  transport.field_terms.clear();
  transport.waves.clear();
  for (std::vector<std::vector<ImageF>>* pairs : {&transport.cosine, &transport.sine})
    for (std::size_t d = 0; d < pairs->size(); ++d)
      for (std::size_t p = 0; p < (*pairs)[d].size(); ++p)
        if (transport.series[d][p].a.size() > 2) (*pairs)[d][p] = {};
  for (ImageF& image : transport.direct) image = {};
  return transport;
}

}  // namespace

// With a_k and b_k of the pitch and the image: forms E = ambient + a_0 mean + sum_k ((a_k cos k d + b_k sin k
// d) C_k - (a_k sin k d - b_k cos k d) S_k), or ambient + the image evaluated directly, each with the factors
// of its image.
std::vector<ImageF> form_images(const Twin& twin, std::size_t camera_index, const Transport& transport,
                                std::optional<ImageRange> range) {
  const auto sequence = expand_sequence(twin.fringes);
  const auto n_pixels = static_cast<std::ptrdiff_t>(transport.mean.size());
  const std::size_t first_image = range ? range->first : 0;
  std::vector<ImageF> images(range ? range->count : sequence.size());
  std::vector<ImageF*> blank;
  for (ImageF& formed_image : images) blank.push_back(&formed_image);
  make_blank(blank, transport.mean.width, transport.mean.height);
  std::vector<Recipe> recipes =
      make_recipes(twin, camera_index, transport, ImageRange{first_image, images.size()});
  for (std::size_t i = 0; i < images.size(); ++i) recipes[i].out = images[i].data.data();
  const bool lit_apart = !light_of_images(twin, twin.cameras.at(camera_index), sequence.size()).empty();
  const bool formed = std::ranges::any_of(
      recipes, [&](const Recipe& r) { return !r.direct && is_formed(transport, r.direction, r.pitch); });
  const std::ptrdiff_t at_a_time = formed ? kFormedAtATime : kPixelsAtATime;
#pragma omp parallel
  {
    FormedPairs pairs;
    const std::span<const FormedPair> none;
#pragma omp for
    for (std::ptrdiff_t from = 0; from < n_pixels; from += at_a_time) {
      std::ptrdiff_t first = from, end = std::min(n_pixels, from + at_a_time);
      if (all_dark(transport, first, end)) continue;
      if (formed) trim_dark(transport, &first, &end);
      for (const Recipe& recipe : recipes) {
        follow(recipe, transport, formed ? pairs.of(twin, transport, recipe, first, end) : none, first, end);
        for (const Term& wave : recipe.waves) add_pair(wave, first, end, recipe.out);
        if (lit_apart) light_up(recipe, transport, first, end);
      }
    }
  }
  return images;
}

std::vector<ImageF> form_patterns(const Twin& twin, std::size_t camera_index, const Transport& transport,
                                  ImageRange range) {
  RenderedCamera seen;
  seen.irradiance = form_images(without_exposures(twin, camera_index), camera_index, transport, range);
  apply_lens_effects(twin.cameras[camera_index], &seen);
  return std::move(seen.irradiance);
}

RenderedCamera form_camera(const Twin& twin, std::size_t camera_index, const Transport& transport,
                           bool references, std::optional<std::size_t> image) {
  const Camera& camera = twin.cameras[camera_index];
  const std::size_t n_images = expand_sequence(twin.fringes).size();
  const ImageRange asked = image ? ImageRange{*image, 1} : ImageRange{0, n_images};
  RenderedCamera out;
  out.camera = camera.name;
  const bool mixes = mixes_patterns(camera, asked);
  if (!mixes) out.irradiance = form_images(twin, camera_index, transport, asked);
  if (references || (!image && needs_white_black(twin.fringes))) add_references(twin, transport, out);
  apply_lens_effects(camera, &out);
  if (mixes) {
    const ImageRange seen = with_neighbours(asked, n_images);
    const std::vector<ImageF> patterns = form_patterns(twin, camera_index, transport, seen);
    for (std::size_t k = asked.first; k < asked.first + asked.count; ++k)
      out.irradiance.push_back(exposed(camera, k, seen_patterns(patterns, seen, k)));
  }
  apply_textures(camera, &out, asked.first);
  static_cast<TraceRecord&>(out) = transport;
  return out;
}

KeptCamera kept_as_floats(RenderedCamera rendered) {
  KeptCamera out;
  for (ImageF& image : rendered.irradiance) out.irradiance.emplace_back(std::move(image));
  rendered.irradiance.clear();
  out.rendered = std::move(rendered);
  return out;
}

KeptCamera keep_camera(const Twin& twin, std::size_t camera_index, Transport transport) {
  const Camera& camera = twin.cameras[camera_index];
  const std::size_t n_images = expand_sequence(twin.fringes).size();
  const bool each_alone = camera.psf_px == 0.0 && !camera.texture && !mixes_patterns(camera, {0, n_images});
  const std::vector<bool> sums = each_alone ? plain_sums(twin, camera_index, transport) : std::vector<bool>();
  if (sums.empty()) return kept_as_floats(form_camera(twin, camera_index, transport));

  KeptCamera out;
  out.rendered.camera = camera.name;
  static_cast<TraceRecord&>(out.rendered) = std::move(static_cast<TraceRecord&>(transport));
  out.irradiance.resize(n_images);
  for (std::size_t first = 0; first < n_images;) {  // those that are formed, as many as follow each other
    std::size_t end = first;
    while (end < n_images && !sums[end]) ++end;
    if (end > first) {
      RenderedCamera formed;
      formed.irradiance = form_images(twin, camera_index, transport, ImageRange{first, end - first});
      apply_lens_effects(camera, &formed);
      std::ranges::move(formed.irradiance, out.irradiance.begin() + static_cast<std::ptrdiff_t>(first));
    }
    first = end + 1;
  }
  if (needs_white_black(twin.fringes)) add_references(twin, transport, out.rendered);
  apply_lens_effects(camera, &out.rendered);
  const auto kept = std::make_shared<const Transport>(only_sums(std::move(transport)));
  std::shared_ptr<const ImageF> factor;
  if (camera.vignetting.kind != Vignetting::Kind::none)
    factor = std::make_shared<const ImageF>(vignetting_map(camera));
  const std::vector<Recipe> recipes = make_recipes(twin, camera_index, *kept, {0, n_images}, sums);
  for (std::size_t k = 0; k < n_images; ++k)
    if (sums[k])
      out.irradiance[k] = GrayImage::sum({.owner = kept,
                                          .constant = kept->ambient.data.data(),
                                          .mean = kept->mean.data.data(),
                                          .cosine = recipes[k].terms.front().cosine,
                                          .sine = recipes[k].terms.front().sine,
                                          .of_mean = recipes[k].level,
                                          .of_cosine = recipes[k].terms.front().c,
                                          .of_sine = recipes[k].terms.front().s,
                                          .more_constant = recipes[k].of_ambient - 1.0F,
                                          .factor = factor ? factor->data.data() : nullptr,
                                          .factor_owner = factor},
                                         kept->mean.width, kept->mean.height);
  return out;
}

bool holds_any_steps(const Twin& twin) {
  if (!throws_pure_cosines(twin) || twin.fringes.has_raster() || twin.projector->pixel_structure ||
      twin.fringes.steps == 0 || !twin.fringes.images.empty())
    return false;
  return std::ranges::none_of(twin.fringes.directions,
                              [](const DirectionFringes& d) { return d.gray.has_value(); });
}

void set_pattern(const Twin& twin, Transport* transport) {
  FT_CHECK(holds_any_steps(twin) && transport->direct.empty(), "a trace that holds any steps");
  transport->series = choose_series(twin);
}

}  // namespace fringetwin::render
