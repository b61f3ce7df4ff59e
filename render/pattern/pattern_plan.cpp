// SPDX-License-Identifier: Apache-2.0
#include "render/pattern/pattern_plan.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "render/pattern/waveform.hpp"
#include "render/pattern/waveform_tables.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

constexpr int kPeriodSamples = 8192;       // linear interpolation: 7e-8 of a cosine
constexpr double kSamplesPerSigma = 64.0;  // of a blurred edge: 7e-6
constexpr double kFewestSamplesPerPx = 16.0;
constexpr std::size_t kMostTexels = 1U << 24;  // of a pass's tables: their offsets travel as floats
constexpr double kWidestEdgeWords = 0.5;  // Gray edges of a larger sigma overlap: a table is cheaper then

Double4 along(Axis axis, double scale, double offset) {
  return {scale, offset, axis == Axis::x ? 1.0 : 0.0, axis == Axis::x ? 0.0 : 1.0};
}

// Returns the largest blur, or a little more.
double widest_blur_px(const Projector& p) {
  double variance = p.blur_px * p.blur_px;
  for (const double more : p.blur_field_px2) variance += std::abs(more);
  return p.has_blur_field() ? std::sqrt(variance) : p.blur_px;
}

double turn_fraction(double turns) { return turns - std::floor(turns); }

// Tables of one period per [direction, pitch]: the steps are shifts of it.
using PeriodTables = std::map<std::pair<int, int>, std::vector<float>>;

// Makes the slot of a phase step from the table of its pitch's period.
DirectSlot periodic_slot(const Twin& twin, const PatternSpec& spec, std::size_t image, double center_px,
                         PeriodTables* tables) {
  const DirectionFringes& d = twin.fringes.directions[spec.direction];
  const auto p = static_cast<std::size_t>(spec.pitch);
  std::vector<float>& table = (*tables)[{spec.direction, spec.pitch}];
  if (table.empty()) {
    PatternSpec first = spec;
    first.step = 0;
    table = periodic_waveform(twin, first, kPeriodSamples);
    table.push_back(table[0]);
    table.push_back(table[1]);
  }
  DirectSlot slot{DirectSlot::Kind::periodic, image, {}, {}, table};
  slot.a = along(d.axis, 1.0 / d.pitches_px[p],
                 turn_fraction((center_px - d.phase_origin_px[p]) / d.pitches_px[p] +
                               static_cast<double>(spec.step) / twin.fringes.steps));
  slot.b[1] = kPeriodSamples;
  // Nodes over a spread of light of one turn: half the phase of the highest harmonic.
  if (twin.projector->optics || twin.has_subsurface())
    slot.b[2] = std::numbers::pi * count_harmonics(*twin.projector, twin.fringes, d.pitches_px[p], 1e-6,
                                                   d.harmonics_of(p), twin.fringes.more_harmonics(d));
  return slot;
}

// Makes the slot of a pattern that is tabulated along its whole axis.
DirectSlot axis_slot(const Twin& twin, const PatternSpec& spec, std::size_t image, double center_px) {
  const double per_px = std::max(kFewestSamplesPerPx, std::ceil(kSamplesPerSigma / twin.projector->blur_px));
  double first_px = 0.0;
  DirectSlot slot{DirectSlot::Kind::axis, image, {}, {}, axis_waveform(twin, spec, per_px, &first_px)};
  const Axis axis = twin.fringes.directions[spec.direction].axis;
  slot.a = along(axis, per_px, (center_px - first_px) * per_px);
  slot.b[1] = static_cast<double>(slot.waveform.size() - 2);
  slot.b[2] = 2.5 / (twin.projector->blur_px * per_px);  // a Gaussian's spectrum ends at 5 / sigma
  return slot;
}

// Makes the slot of a pixel raster without Gaussian blur: the frame buffer's pixels are exact cells.
DirectSlot pixel_slot(const Twin& twin, const PatternSpec& spec, std::size_t image, double center_px) {
  int first_px = 0;
  DirectSlot slot{DirectSlot::Kind::pixel, image, {}, {}, pixel_waveform(twin, spec, &first_px)};
  const Axis axis = twin.fringes.directions[spec.direction].axis;
  slot.a = along(axis, 1.0, center_px - first_px + 0.5);
  slot.b[1] = static_cast<double>(slot.waveform.size() - 1);
  return slot;
}

// Makes the slot of a Gray image, two levels with edges in known places; the shader finds the code words.
DirectSlot gray_slot(const Twin& twin, const PatternSpec& spec, std::size_t image, double center_px) {
  const DirectionFringes& d = twin.fringes.directions[spec.direction];
  FT_CHECK(d.gray.has_value(), "Gray pattern of a direction without Gray code");
  const bool half = spec.is_complementary(), inverse = spec.is_inverse();
  const double words_per_px = (half ? 2.0 : 1.0) / d.pitches_px.front();
  const double offset =
      (center_px - d.phase_origin_px.front()) * words_per_px - d.gray->offset_periods * (half ? 2.0 : 1.0);
  const int bits = d.gray->bits + (half ? 1 : 0);
  const int bit = half ? bits - 1 : spec.bit;
  const double dark = twin.projector->response(0.0), bright = twin.projector->response(1.0);
  DirectSlot slot{DirectSlot::Kind::gray, image, along(d.axis, words_per_px, offset), {}, {}};
  slot.b = {static_cast<double>(bits - 1 - bit), static_cast<double>((1 << bits) - 1),
            inverse ? bright : dark, inverse ? dark : bright};
  return slot;
}

// Makes the slot of a pattern image: its raster after the response; the shader averages its pixels.
DirectSlot image_slot(const Twin& twin, const PatternSpec& spec, std::size_t image) {
  const ImageF& levels = *twin.fringes.images.at(spec.image).levels;
  FT_CHECK(levels.width == twin.projector->lens.width() && levels.height == twin.projector->lens.height(),
           "pattern images have the projector's size");
  DirectSlot slot{DirectSlot::Kind::image, image, {}, {}, levels.data};
  if (twin.projector->quantise_bits) {
    const auto most = static_cast<float>(std::exp2(*twin.projector->quantise_bits) - 1.0);
    for (float& level : slot.waveform) level = std::round(level * most) / most;
  }
  if (!is_linear(twin.projector->response))
    for (float& level : slot.waveform)
      level = static_cast<float>(twin.projector->response(static_cast<double>(level)));
  slot.b[1] = levels.width;
  slot.b[2] = levels.height;
  return slot;
}

// Sets the slots' table offsets within the pass's one waveform buffer; throws where that would be too large.
void place_waveforms(const Twin& twin, PassPlan* pass) {
  std::size_t first = pass->gaps.size();
  for (DirectSlot& slot : pass->direct) {
    if (slot.kind != DirectSlot::Kind::gray) slot.b[0] = static_cast<double>(first);
    first += slot.waveform.size();
  }
  if (first > kMostTexels && twin.projector->pixel_structure)
    throw UserError(ExitCode::usage, "projector.blur_px",
                    "is so small that the blurred pixels of one pass need more than 64 MB",
                    "use 0, or a larger blur");
  if (first > kMostTexels)
    throw UserError(
        ExitCode::usage, "fringes.gray",
        "the code words are too narrow for the projector's size: their images need more than 64 MB",
        "fewer bits or a larger pitch");
}

}  // namespace

int PassPlan::count(DirectSlot::Kind kind) const {
  return static_cast<int>(
      std::ranges::count_if(direct, [kind](const DirectSlot& s) { return s.kind == kind; }));
}

namespace {

using Chain = std::vector<PitchSlot>;  // a pitch and its harmonics: they stay in one pass

// Returns the cosine/sine pairs of all pitches that are carried as a series.
std::vector<Chain> harmonic_chains(const Twin& twin, const SeriesTable& series, double center_x_px,
                                   double center_y_px) {
  std::vector<Chain> chains;
  if (twin.fringes.steps == 0) return chains;
  const double blur_px = twin.projector->least_blur_px();
  for (std::size_t d = 0; d < twin.fringes.directions.size(); ++d) {
    const DirectionFringes& direction = twin.fringes.directions[d];
    const double center = direction.axis == Axis::x ? center_x_px : center_y_px;
    for (std::size_t p = 0; p < direction.pitches_px.size(); ++p) {
      const PhaseSeries& light = series[d][p];
      const int harmonics = static_cast<int>(light.a.size()) - 1;
      if (harmonics < 1) continue;
      FT_CHECK(harmonics <= kMostPairs, "harmonics of one pitch");
      Chain chain;
      for (int k = 1; k <= harmonics; ++k) {
        const double pitch = direction.pitches_px[p] / k;
        const double turns = turn_fraction((center - direction.phase_origin_px[p]) / pitch);
        PitchSlot slot{d, p, k, along(direction.axis, 1.0 / pitch, turns)};
        if (k > 1)
          slot.share = light.size(static_cast<std::size_t>(k)) / light.size(1) *
                       blur_attenuation(k, blur_px, direction.pitches_px[p]) /
                       blur_attenuation(1, blur_px, direction.pitches_px[p]);
        chain.push_back(slot);
      }
      chains.push_back(std::move(chain));
    }
  }
  return chains;
}

// Throws for combinations of effects that have no sound treatment here: they are refused, not left out.
void refuse_combinations(const Twin& twin) {
  const Projector& p = *twin.projector;
  const bool gaps = p.pixel_structure && p.pixel_fill < 1.0, images = !twin.fringes.images.empty();
  const auto refuse = [&](const char* what, const char* hint) {
    throw UserError(ExitCode::usage, twin.file.string(), what, hint);
  };
  if (p.optics && gaps)
    refuse("gaps between the projector's pixels (pixel_fill below 1) cannot be combined with its defocus",
           "describe the blur of the gaps by blur_px");
  if (p.has_halo() && images)
    refuse("pattern images cannot be combined with the projector's halo", "leave out halo");
  if (p.has_halo() && gaps)
    refuse("gaps between the projector's pixels (pixel_fill below 1) cannot be combined with its halo",
           "describe the blur of the gaps by blur_px");
  if (p.optics && images)
    refuse("pattern images cannot be combined with the projector's defocus", "describe the blur by blur_px");
  if (p.has_blur_field() && (p.pixel_structure || p.optics))
    refuse("a blur that varies over the projector's image cannot be combined with its pixels or its defocus",
           "leave out blur_field_px2");
  if (twin.fringes.has_harmonics_field() && (p.pixel_structure || twin.render.bounces > 0))
    refuse(
        "harmonics that vary over the projector's image cannot be combined with its pixels or with bounces",
        "leave out harmonics_field");
  if (twin.fringes.has_image_harmonics() && p.pixel_structure)
    refuse("harmonics of single images cannot be combined with the projector's pixels",
           "leave out image_harmonics");
  if (twin.fringes.has_raster() && (p.pixel_structure || twin.has_subsurface()))
    refuse("waves of the raster cannot be combined with the projector's pixels or with light below surfaces",
           "leave out raster");
  if (twin.has_subsurface() && (p.pixel_structure || p.optics || images))
    refuse(
        "light below surfaces cannot be combined with the projector's pixels, its defocus or pattern images",
        "leave out mean_free_path_mm, or describe the defocus by blur_px");
  if (p.blur_px > 0.0 && gaps && images)
    refuse("pattern images with gaps between the pixels cannot be blurred",
           "use blur_px = 0 or pixel_fill = 1");
}

// Throws where a pattern would have to be tabulated and the blur varies.
void refuse_table_of_varying_blur(const Twin& twin, const char* why) {
  if (twin.projector->has_blur_field())
    throw UserError(
        ExitCode::usage, twin.file.string(),
        std::string("a blur that varies over the projector's image cannot be rendered here: ") + why,
        "leave out blur_field_px2, or blur the pattern more");
}

// Distributes the chains over the passes in even shares; returns false when some pass would hold too many.
bool distribute(const std::vector<Chain>& chains, std::size_t most_pairs, std::vector<PassPlan>* passes) {
  std::size_t total = 0, placed = 0;
  for (const Chain& c : chains) total += c.size();
  for (PassPlan& pass : *passes) pass.pitches.clear();
  for (const Chain& c : chains) {
    const std::size_t k =
        std::min(placed * passes->size() / std::max<std::size_t>(1, total), passes->size() - 1);
    auto& slots = (*passes)[k].pitches;
    slots.insert(slots.end(), c.begin(), c.end());
    if (slots.size() > most_pairs) return false;
    placed += c.size();
  }
  return true;
}

}  // namespace

std::size_t PassPlan::table_size() const {
  std::size_t n = gaps.size();
  for (const DirectSlot& slot : direct) n += slot.waveform.size();
  return n;
}

PassPlan PassPlan::without_harmonics() const {
  PassPlan out = *this;
  std::erase_if(out.pitches, [](const PitchSlot& p) { return p.harmonic > 1; });
  return out;
}

std::uint32_t PassPlan::fundamentals() const {
  std::uint32_t mask = ~0U;
  for (std::size_t i = 0; i < pitches.size(); ++i)
    if (pitches[i].harmonic != 1) mask &= ~(1U << i);
  return mask;
}

std::vector<PassPlan> plan_passes(const Twin& twin, const SeriesTable& series, double center_x_px,
                                  double center_y_px, std::size_t most_pairs) {
  refuse_combinations(twin);
  const std::vector<Chain> chains = harmonic_chains(twin, series, center_x_px, center_y_px);
  std::vector<DirectSlot> direct;
  PeriodTables tables;
  const auto sequence = expand_sequence(twin.fringes);
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    const PatternSpec& spec = sequence[i];
    if (spec.is_image()) {
      direct.push_back(image_slot(twin, spec, i));
      continue;
    }
    const auto d = static_cast<std::size_t>(spec.direction), p = static_cast<std::size_t>(spec.pitch);
    // a pattern that lies further is met where an unmoved one is met earlier
    const double center = (twin.fringes.directions[d].axis == Axis::x ? center_x_px : center_y_px) -
                          twin.projector->image_shift_px(i);
    if (twin.projector->pixel_structure) {
      direct.push_back(twin.projector->blur_px > 0.0 ? axis_slot(twin, spec, i, center)
                                                     : pixel_slot(twin, spec, i, center));
    } else if (!spec.is_gray()) {
      if (!series[d][p].a.empty()) continue;
      refuse_table_of_varying_blur(twin, "the fringes have more harmonics than one trace carries");
      direct.push_back(periodic_slot(twin, spec, i, center, &tables));
    } else {
      DirectSlot slot = gray_slot(twin, spec, i, center);
      // Defocus of blurred edges is made from a table, too, and so is a halo.
      const bool overlap = twin.projector->has_halo() ||
                           widest_blur_px(*twin.projector) * slot.a[0] > kWidestEdgeWords ||
                           (twin.projector->optics && twin.projector->blur_px > 0.0);
      if (overlap)
        refuse_table_of_varying_blur(twin, twin.projector->has_halo() ? "Gray code with a halo"
                                                                      : "the edges of the Gray code overlap");
      direct.push_back(overlap ? axis_slot(twin, spec, i, center) : std::move(slot));
    }
  }
  std::ranges::stable_sort(direct, {}, &DirectSlot::kind);

  // The passes get even shares, so that the passes can use the same pipeline where the counts agree.
  std::size_t most_direct = MAX_DIRECT;
  if (!twin.fringes.images.empty())
    most_direct =
        std::clamp<std::size_t>(kMostTexels / twin.fringes.images.front().levels->size(), 1, MAX_DIRECT);
  std::vector<PassPlan> passes(std::max<std::size_t>(1, (direct.size() + most_direct - 1) / most_direct));
  while (!distribute(chains, most_pairs, &passes)) passes.emplace_back();
  for (std::size_t k = 0; k < passes.size(); ++k) {
    const auto share = [&](std::size_t i) { return direct.size() * i / passes.size(); };
    for (std::size_t i = share(k); i < share(k + 1); ++i) passes[k].direct.push_back(std::move(direct[i]));
    passes[k].gaps = gap_waveform(*twin.projector);
    place_waveforms(twin, &passes[k]);
  }
  return passes;
}

}  // namespace fringetwin::render
