// SPDX-License-Identifier: Apache-2.0
// [fringes] of twin.toml.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/file/twin_file.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin {
namespace {

constexpr double kMostPatternPixels = 1e9;  // they are all kept, 4 bytes each: 480 images of full HD

/// Gray code of a direction: [fringes.gray], each key overridden by [fringes.x.gray].
GrayCode read_gray(const TomlTable& table, GrayCode gray, bool is_override) {
  table.allow({"bits", "order", "complementary", "offset_periods", "threshold"});
  if (!is_override || table.has("bits")) gray.bits = table.required_integer("bits", 1, 16);
  if (const auto order = table.choice("order", {"msb-first", "lsb-first"}))
    gray.lsb_first = *order == "lsb-first";
  gray.complementary = table.boolean("complementary").value_or(gray.complementary);
  gray.offset_periods = table.number_or("offset_periods", gray.offset_periods);
  if (const auto threshold = table.choice("threshold", {"mean", "inverse", "white-black"}))
    gray.threshold = *threshold == "mean"      ? GrayCode::Threshold::mean
                     : *threshold == "inverse" ? GrayCode::Threshold::inverse
                                               : GrayCode::Threshold::white_black;
  return gray;
}

/// A number for all pitches, or one per pitch.
std::vector<double> read_phase_origin(const TomlTable& table, std::size_t n_pitches) {
  static const std::string key = "phase_origin_px";
  if (!table.is_array(key)) return std::vector<double>(n_pitches, table.number_or(key, 0.0));
  const std::vector<double> values = *table.numbers(key);
  if (values.size() != n_pitches)
    table.fail(key, fmt::format("must be a number or one per pitch: {} values for {} pitches", values.size(),
                                n_pitches));
  return values;
}

std::vector<double> read_pitches(const TomlTable& table) {
  const std::vector<double> pitches = *table.numbers("pitches_px", NumberRange::positive(1e-3, 1e6));
  if (pitches.empty()) table.fail("pitches_px", "must have one pitch or more");
  std::vector<double> sorted = pitches;
  std::ranges::sort(sorted);
  if (std::ranges::adjacent_find(sorted) != sorted.end())
    table.fail("pitches_px", "has the same pitch twice");
  return pitches;
}

/// Returns the pairs of these rows, and adds their sizes to `sum`.
Harmonics pairs_of(const std::vector<std::vector<double>>& rows, double& sum) {
  Harmonics list;
  for (const std::vector<double>& row : rows) {
    list.push_back({row[0], row[1]});
    sum += std::hypot(row[0], row[1]);
  }
  return list;
}

/// Returns the same of harmonics from the lowest order on, of which there may be so many.
Harmonics read_pairs(const TomlTable& table, const std::string& key,
                     const std::vector<std::vector<double>>& rows, double& sum, int lowest = 2) {
  if (const int most = kHighestHarmonic + 1 - lowest; static_cast<int>(rows.size()) > most)
    table.fail(key, fmt::format("has {} pairs: the harmonics {} ... {} are {}", rows.size(), lowest,
                                kHighestHarmonic, most));
  return pairs_of(rows, sum);
}

void check_sum(const TomlTable& table, const std::string& key, double sum) {
  if (sum > 1.0)
    table.fail(key, fmt::format("add up to {:.3g} of the full scale, at most 1", sum),
               "amplitudes are fractions of the full scale, as mean and amplitude are");
}

/// One list of pairs for all pitches, or one per pitch.
std::vector<Harmonics> read_harmonics(const TomlTable& table, std::size_t n_pitches) {
  static const std::string key = "harmonics";
  const auto lists = table.lists_of_rows(key, 2, NumberRange::between(-1.0, 1.0));
  if (!lists) return {};
  if (lists->size() != 1 && lists->size() != n_pitches)
    table.fail(key, fmt::format("must be one list of pairs or one per pitch: {} lists for {} pitches",
                                lists->size(), n_pitches));
  std::vector<Harmonics> harmonics;
  for (const auto& rows : *lists) {
    double sum = 0.0;
    harmonics.push_back(read_pairs(table, key, rows, sum));
    check_sum(table, key, sum);
  }
  harmonics.resize(n_pitches, harmonics.front());
  return harmonics;
}

/// One list of pairs per term of the field, of the first order or up to the second.
std::vector<Harmonics> read_harmonics_field(const TomlTable& table) {
  static const std::string key = "harmonics_field";
  const auto lists = table.lists_of_rows(key, 2, NumberRange::between(-1.0, 1.0));
  if (!lists) return {};
  if (lists->size() != 2 && lists->size() != kHarmonicsFieldTerms)
    table.fail(
        key, fmt::format("has {} lists of pairs", lists->size()),
        fmt::format("give 2 or {}: all terms of the first order, or up to the second", kHarmonicsFieldTerms));
  std::vector<Harmonics> field;
  double sum = 0.0;
  for (const auto& rows : *lists) field.push_back(read_pairs(table, key, rows, sum));
  check_sum(table, key, sum);
  return field;
}

/// Waves of the projector's pixels: their pitch, the first order, a pair for each from there on.
Raster read_raster(const TomlTable& table) {
  const std::optional<TomlTable> inner = table.table("raster");
  if (!inner) return {};
  inner->allow({"pitch_px", "first", "waves"});
  Raster raster;
  raster.pitch_px = inner->number_or("pitch_px", 1.0, NumberRange::between(0.1, 10.0));
  raster.first_order = inner->required_integer("first", 2, kHighestRasterOrder);
  const auto lists = inner->lists_of_rows("waves", 2, NumberRange::between(-1.0, 1.0));
  if (!lists || lists->size() != 1 || lists->front().empty())
    inner->fail("waves", "must be a list of pairs, one for each order from `first` on",
                "waves = [[a, b], ...], fractions of the full scale");
  if (lists->front().size() > kMostRasterWaves)
    inner->fail("waves", fmt::format("has {} pairs, at most {}", lists->front().size(), kMostRasterWaves));
  double sum = 0.0;
  raster.waves = pairs_of(lists->front(), sum);
  check_sum(*inner, "waves", sum);
  return raster;
}

/// A number for all pitches, or one per pitch; none where each is 1.
std::vector<double> read_contrast(const TomlTable& table, std::size_t n_pitches) {
  static const std::string key = "contrast";
  static const NumberRange range{.min = 0.0, .max = kLargestContrast, .min_excluded = true};
  if (!table.has(key)) return {};
  if (!table.is_array(key)) return std::vector<double>(n_pitches, table.number_or(key, 1.0, range));
  const std::vector<double> values = *table.numbers(key, range);
  if (values.size() != n_pitches)
    table.fail(key, fmt::format("must be a number or one per pitch: {} values for {} pitches", values.size(),
                                n_pitches));
  return values;
}

/// Returns the size of the first Fourier coefficient of a period.
double first_harmonic(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  std::complex<double> sum = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i)
    sum += std::polar(values[i], -2.0 * std::numbers::pi * static_cast<double>(i) / n);
  return std::abs(sum) / n;
}

Waveform read_waveform(const TomlTable& table) {
  static const std::string key = "waveform";
  if (!table.has(key)) return {};
  if (table.is_string(key)) {
    const std::string word = *table.choice(key, {"sine", "binary"});
    if (word == "sine") return {};
    return {Waveform::Kind::levels, {1.0, 0.0, 0.0, 1.0}};
  }
  if (!table.is_table(key))
    table.fail(key, "must be \"sine\", \"binary\", { table = [...] } or { levels = [...] }");
  const TomlTable inner = *table.table(key);
  inner.allow({"table", "levels"});
  if (inner.has("table") == inner.has("levels"))
    table.fail(key, "must have either table or levels",
               "{ table = [...] } is linear between its values, { levels = [...] } constant");
  const std::string kind = inner.has("table") ? "table" : "levels";
  Waveform waveform{kind == "table" ? Waveform::Kind::table : Waveform::Kind::levels,
                    *inner.numbers(kind, NumberRange::between(0.0, 1.0))};
  constexpr std::size_t kFewest = 2, kMost = 4096;
  if (waveform.values.size() < kFewest || waveform.values.size() > kMost)
    inner.fail(kind,
               fmt::format("must have {} ... {} values, has {}", kFewest, kMost, waveform.values.size()));
  constexpr double kLeast = 1e-3;
  if (first_harmonic(waveform.values) < kLeast)
    inner.fail(kind, "has no first harmonic: such a fringe has no phase", "give the values of one period");
  return waveform;
}

DirectionFringes read_direction(const TomlTable& table, Axis axis) {
  const std::string key = axis_name(axis);
  const std::optional<TomlTable> own = table.table(key);
  if (own)
    own->allow(
        {"pitches_px", "phase_origin_px", "harmonics", "harmonics_field", "raster", "contrast", "gray"});
  const auto source = [&](const std::string& name) -> const TomlTable& {
    return own && own->has(name) ? *own : table;
  };
  DirectionFringes direction;
  direction.axis = axis;
  if (!source("pitches_px").has("pitches_px"))
    table.fail("pitches_px", fmt::format("is missing (direction \"{}\")", key));
  direction.pitches_px = read_pitches(source("pitches_px"));
  direction.phase_origin_px = read_phase_origin(source("phase_origin_px"), direction.pitches_px.size());
  direction.harmonics = read_harmonics(source("harmonics"), direction.pitches_px.size());
  direction.harmonics_field = read_harmonics_field(source("harmonics_field"));
  direction.raster = read_raster(source("raster"));
  direction.contrast = read_contrast(source("contrast"), direction.pitches_px.size());
  if (const auto gray = table.table("gray")) direction.gray = read_gray(*gray, {}, false);
  if (own)
    if (const auto gray = own->table("gray"))
      direction.gray = read_gray(*gray, direction.gray.value_or(GrayCode{}), direction.gray.has_value());
  return direction;
}

Unwrap read_unwrap(const TomlTable& table) {
  const std::string name =
      table.choice("unwrap", {"heterodyne", "hierarchical", "gray", "none"}).value_or("heterodyne");
  if (name == "heterodyne") return Unwrap::heterodyne;
  if (name == "hierarchical") return Unwrap::hierarchical;
  return name == "gray" ? Unwrap::gray : Unwrap::none;
}

void check_gray(const TomlTable& table, const Fringes& fringes, const DirectionFringes& direction) {
  const std::string axis = axis_name(direction.axis);
  if (direction.pitches_px.size() != 1)
    table.fail("pitches_px",
               fmt::format("must be one pitch with unwrap = \"gray\", are {} (direction \"{}\")",
                           direction.pitches_px.size(), axis));
  if (!direction.gray)
    table.fail("unwrap", fmt::format("= \"gray\" needs [fringes.gray] (direction \"{}\")", axis),
               "give its bits");
  if (fringes.steps == 0 && direction.gray->threshold == GrayCode::Threshold::mean)
    table.fail("gray", "has threshold = \"mean\" of the phase steps, but steps = 0",
               "use \"inverse\" or \"white-black\"");
}

/// Also drops a Gray code that the unwrapping does not use.
void check_unwrap(const TomlTable& table, Fringes& fringes) {
  for (DirectionFringes& direction : fringes.directions) {
    const std::size_t n = direction.pitches_px.size();
    if (fringes.unwrap == Unwrap::gray) {
      check_gray(table, fringes, direction);
      continue;
    }
    // A template may carry the table along: it adds no images to the sequence then.
    if (direction.gray)
      warn(table.where("gray") + ": [fringes.gray] has no effect without unwrap = \"gray\"");
    direction.gray.reset();
    if (fringes.unwrap == Unwrap::heterodyne && n != 3)
      table.fail("pitches_px", fmt::format("must be 3 pitches with unwrap = \"heterodyne\", are {}", n));
    if (fringes.unwrap == Unwrap::hierarchical && n < 2)
      table.fail("pitches_px",
                 fmt::format("must be 2 pitches or more with unwrap = \"hierarchical\", are {}", n));
  }
  if (fringes.steps == 0 && fringes.unwrap != Unwrap::gray)
    table.fail("steps", "= 0 means Gray code only and needs unwrap = \"gray\"");
}

/// Before the sequence is made anywhere: a short file can ask for any number of images.
void check_length(const TomlTable& table, const Fringes& fringes) {
  const auto images = table.strings("images");
  std::size_t n = images ? images->size() : 0;
  for (const DirectionFringes& direction : fringes.directions)
    n += direction.pitches_px.size() * static_cast<std::size_t>(fringes.steps);
  if (n > kLongestSequence)
    table.fail("",
               fmt::format("asks for a sequence of {} images, at most {} are possible", n, kLongestSequence),
               "give fewer steps, pitches or images");
}

}  // namespace

Fringes read_fringes(const TomlTable& root) {
  const auto found = root.table("fringes");
  if (!found) root.fail("fringes", "is missing", "a twin needs [fringes]");
  const TomlTable& table = *found;
  table.allow({"directions", "pitches_px", "steps", "unwrap", "mean", "amplitude", "phase_origin_px",
               "waveform", "harmonics", "harmonics_field", "image_harmonics", "raster", "contrast", "gray",
               "images", "x", "y"});
  Fringes fringes;
  fringes.steps = table.required_integer("steps", 0, 1000);
  if (fringes.steps == 1 || fringes.steps == 2)
    table.fail("steps", fmt::format("must be >= 3 (or 0: Gray code only), is {}", fringes.steps));
  fringes.unwrap = read_unwrap(table);
  fringes.mean = table.number_or("mean", fringes.mean, NumberRange::between(0.0, 1.0));
  fringes.amplitude =
      table.number_or("amplitude", fringes.amplitude, {.min = 0.0, .max = 1.0, .min_excluded = true});
  constexpr double kRounding = 1e-12;  // 0.7 + 0.3 may exceed 1 in the last bit
  if (fringes.mean - fringes.amplitude < -kRounding || fringes.mean + fringes.amplitude > 1.0 + kRounding)
    table.fail(table.has("amplitude") ? "amplitude" : "mean",
               fmt::format("leaves the projector's range: mean {} +- amplitude {} must lie within 0 ... 1",
                           fringes.mean, fringes.amplitude));
  fringes.waveform = read_waveform(table);
  const auto directions = table.strings("directions");
  if (!directions || directions->empty())
    table.fail("directions", directions ? "must not be empty" : "is missing", "e.g. directions = [\"x\"]");
  for (const std::string& name : *directions) {
    if (name != "x" && name != "y")
      table.fail("directions", fmt::format("must be \"x\" or \"y\", has \"{}\"", name));
    if (std::ranges::count(*directions, name) > 1)
      table.fail("directions", fmt::format("has \"{}\" twice", name));
    fringes.directions.push_back(read_direction(table, name == "x" ? Axis::x : Axis::y));
  }
  for (const std::string axis : {"x", "y"})
    if (table.has(axis) && std::ranges::find(*directions, axis) == directions->end())
      table.fail(axis, fmt::format("has no effect: \"{}\" is not in directions", axis));
  check_unwrap(table, fringes);
  check_length(table, fringes);
  return fringes;
}

void read_image_harmonics(const TomlTable& root, Twin& twin) {
  static const std::string key = "image_harmonics";
  const TomlTable table = *root.table("fringes");
  const auto lists = table.lists_of_rows(key, 2, NumberRange::between(-1.0, 1.0));
  if (!lists || (lists->size() == 1 && lists->front().empty())) return;  // [] is none
  const std::vector<PatternSpec> sequence = expand_sequence(twin.fringes);
  if (lists->size() != sequence.size())
    table.fail(
        key, fmt::format("has {} lists of pairs, the sequence has {} images", lists->size(), sequence.size()),
        "give a list for each image, in the order of their numbers: [] where there are none");
  std::vector<Harmonics>& harmonics = twin.fringes.image_harmonics;
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    double sum = 0.0;
    harmonics.push_back(read_pairs(table, key, (*lists)[i], sum, 1));
    check_sum(table, key, sum);
    if (sequence[i].kind != PatternSpec::Kind::phase_step && sum > 0.0)
      table.fail(key, fmt::format("has harmonics of image {}, which is no phase step and has no phase", i),
                 "use []");
  }
  if (!twin.fringes.has_image_harmonics()) harmonics.clear();
  if (twin.fringes.has_image_harmonics() && twin.projector && twin.projector->pixel_structure)
    table.fail(key,
               "cannot be combined with pixel_structure: its pixels show the same waveform in all images");
}

std::vector<PatternImage> read_pattern_images(const TomlTable& root,
                                              const std::optional<Projector>& projector,
                                              const TwinFileContext& context) {
  const auto table = root.table("fringes");
  const auto names = table->strings("images");
  if (!names) return {};
  if (!projector) table->fail("images", "need a projector that shows them", "add a [projector] section");
  const double pixels =
      1.0 * static_cast<double>(names->size()) * projector->lens.width() * projector->lens.height();
  if (pixels > kMostPatternPixels * file_limits_factor())
    table->fail("images",
                fmt::format("have {:.2g} pixels in all, at most {:.2g} are read", pixels,
                            kMostPatternPixels * file_limits_factor()),
                "--limits 10 reads ten times as much");
  std::vector<PatternImage> images;
  for (const std::string& name : *names) {
    PatternImage image;
    image.file = resolve_path(name, context.folder, table->where("images"), ExitCode::usage);
    LoadedGray loaded =
        fringetwin::read_gray(image.file, RightSize{projector->lens.width(), projector->lens.height(),
                                                    "the projector", "images are shown pixel for pixel"});
    const auto full_scale = static_cast<float>((1 << loaded.file_bits) - 1);
    for (float& level : loaded.image.data) level /= full_scale;
    image.levels = std::make_shared<const ImageF>(std::move(loaded.image));
    context.files->push_back(image.file);
    images.push_back(std::move(image));
  }
  return images;
}

}  // namespace fringetwin
