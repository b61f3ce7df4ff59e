// SPDX-License-Identifier: Apache-2.0
#include "render/pattern/form_images.hpp"

#include <algorithm>
#include <cmath>

#include "render/pattern/camera_effects.hpp"
#include "render/pattern/response_series.hpp"
#include "render/pattern/transport_images.hpp"
#include "render/pattern/waveform.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

// All images are formed for so many pixels at a time: what they read in common then stays in the cache.
constexpr std::ptrdiff_t kPixelsAtATime = 8192;

struct Term {
  const float *cosine, *sine;
  float c, s;
};

// Describes one image as a sum over arrays of the transport.
struct Recipe {
  float* out = nullptr;
  const float* direct = nullptr;  ///< instead of all others
  float level = 0.0F;
  std::vector<Term> terms;
};

// Returns the recipe of an image of the sequence; its `out` is still to be set.
Recipe make_recipe(const Twin& twin, const Transport& transport, const PatternSpec& spec, std::size_t index) {
  Recipe recipe;
  if (index < transport.direct.size() && !transport.direct[index].empty()) {
    recipe.direct = transport.direct[index].data.data();
    return recipe;
  }
  FT_CHECK(!spec.is_gray() && !transport.cosine.empty(), "transport without the image's sums");
  const auto d = static_cast<std::size_t>(spec.direction), p = static_cast<std::size_t>(spec.pitch);
  const double delta = kTwoPi * spec.step / twin.fringes.steps;
  const PhaseSeries& series = transport.series[d][p];
  const std::vector<double>& a = series.a;
  FT_CHECK(a.size() >= 2, "a response has a mean and a fundamental");
  recipe.level = static_cast<float>(a[0]);
  for (std::size_t h = 1; h < a.size(); ++h) {
    const ImageF& cosine = h == 1 ? transport.cosine[d][p] : transport.harmonics[d][p][h - 2].cosine;
    const ImageF& sine = h == 1 ? transport.sine[d][p] : transport.harmonics[d][p][h - 2].sine;
    const double c = std::cos(static_cast<double>(h) * delta), s = std::sin(static_cast<double>(h) * delta);
    const double b = series.sine(h);
    recipe.terms.push_back({cosine.data.data(), sine.data.data(), static_cast<float>(a[h] * c + b * s),
                            static_cast<float>(a[h] * s - b * c)});
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

// Forms the pixels first ... end - 1 of one image.
void follow(const Recipe& recipe, const Transport& transport, std::ptrdiff_t first, std::ptrdiff_t end) {
  const float *ambient = transport.ambient.data.data(), *mean = transport.mean.data.data();
  float* out = recipe.out;
  if (recipe.direct) {
    for (std::ptrdiff_t k = first; k < end; ++k) out[k] = ambient[k] + recipe.direct[k];
    return;
  }
  const Term one = recipe.terms.front();
  const float level = recipe.level;
  for (std::ptrdiff_t k = first; k < end; ++k)
    out[k] = ambient[k] + level * mean[k] + one.c * one.cosine[k] - one.s * one.sine[k];
  for (std::size_t h = 1; h < recipe.terms.size(); ++h) {
    const Term term = recipe.terms[h];
    for (std::ptrdiff_t k = first; k < end; ++k) out[k] += term.c * term.cosine[k] - term.s * term.sine[k];
  }
}

}  // namespace

// Forms E = ambient + a_0 mean + sum_k ((a_k cos k d + b_k sin k d) C_k - (a_k sin k d - b_k cos k d) S_k),
// or ambient + the image evaluated directly.
std::vector<ImageF> form_images(const Twin& twin, const Transport& transport) {
  const auto sequence = expand_sequence(twin.fringes);
  const auto n_pixels = static_cast<std::ptrdiff_t>(transport.mean.size());
  std::vector<ImageF> images(sequence.size());
  std::vector<ImageF*> blank;
  for (ImageF& image : images) blank.push_back(&image);
  make_blank(blank, transport.mean.width, transport.mean.height);
  std::vector<Recipe> recipes;
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    recipes.push_back(make_recipe(twin, transport, sequence[i], i));
    recipes.back().out = images[i].data.data();
  }
#pragma omp parallel for
  for (std::ptrdiff_t first = 0; first < n_pixels; first += kPixelsAtATime) {
    const std::ptrdiff_t end = std::min(n_pixels, first + kPixelsAtATime);
    if (all_dark(transport, first, end)) continue;
    for (const Recipe& recipe : recipes) follow(recipe, transport, first, end);
  }
  return images;
}

RenderedCamera form_camera(const Twin& twin, std::size_t camera_index, const Transport& transport,
                           bool references) {
  RenderedCamera out;
  out.camera = twin.cameras[camera_index].name;
  out.irradiance = form_images(twin, transport);
  if (references || needs_white_black(twin.fringes)) {
    const auto level = [&](double value) {
      const auto factor = static_cast<float>(twin.projector->response(value));
      ImageF image = transport.ambient;
      for (std::size_t i = 0; i < image.size(); ++i) image.data[i] += factor * transport.mean.data[i];
      return image;
    };
    out.white = level(1.0);
    out.black = level(0.0);
  }
  apply_camera_effects(twin.cameras[camera_index], &out);
  static_cast<TraceRecord&>(out) = transport;
  return out;
}

bool holds_any_steps(const Twin& twin) {
  if (!throws_pure_cosines(twin) || twin.projector->pixel_structure || twin.fringes.steps == 0 ||
      !twin.fringes.images.empty())
    return false;
  return std::ranges::none_of(twin.fringes.directions,
                              [](const DirectionFringes& d) { return d.gray.has_value(); });
}

void set_pattern(const Twin& twin, Transport* transport) {
  FT_CHECK(holds_any_steps(twin) && transport->direct.empty(), "a trace that holds any steps");
  transport->series = choose_series(twin);
}

}  // namespace fringetwin::render
