// SPDX-License-Identifier: Apache-2.0
// What [fringes] says beside pitches and steps, and how the projector's image is blurred: harmonics,
// waveforms, a field. Values are those written; of the blur's field: 1e-12 px^2 for rounding, 1e-3 px for its
// least value, which is looked for on nodes 1/32 of the image apart.
#include <cmath>

#include "tests/support/twin/twin_file_fixture.hpp"

namespace fringetwin::testing::twin_file_fringes_test {
namespace {

using ::testing::HasSubstr;

class TwinFileFringes : public TwinFile {};

// Harmonics for all pitches, for each, and of one direction alone.
TEST_F(TwinFileFringes, HarmonicsOfTheFringes) {
  const std::string head = kHead + kCamera +
                           "[fringes]\ndirections = [\"x\", \"y\"]\npitches_px = [64, 16]\nsteps = 8\n"
                           "unwrap = \"hierarchical\"\n";
  const Fringes none = load(head).fringes;
  EXPECT_FALSE(none.has_harmonics());
  EXPECT_TRUE(none.directions[0].harmonics_of(1).empty());
  EXPECT_FALSE(load(head + "harmonics = []\n").fringes.has_harmonics());
  EXPECT_FALSE(load(head + "harmonics = [[0, 0]]\n").fringes.has_harmonics());
  const Fringes all = load(head + "harmonics = [[0.01, -0.02], [0, 0.003]]\n").fringes;
  EXPECT_TRUE(all.has_harmonics());
  const Harmonics expected{{0.01, -0.02}, {0.0, 0.003}};
  for (const DirectionFringes& d : all.directions)
    for (const std::size_t pitch : {0, 1}) EXPECT_EQ(d.harmonics_of(pitch), expected);
  const Fringes each =
      load(head + "harmonics = [[[0.01, 0.02]], []]\n[fringes.y]\nharmonics = [[0.1, 0.2], [0.3, 0.4]]\n")
          .fringes;
  EXPECT_EQ(each.directions[0].harmonics_of(0), (Harmonics{{0.01, 0.02}}));
  EXPECT_TRUE(each.directions[0].harmonics_of(1).empty());
  for (const std::size_t pitch : {0, 1})
    EXPECT_EQ(each.directions[1].harmonics_of(pitch), (Harmonics{{0.1, 0.2}, {0.3, 0.4}}));
}

// A list of pairs per term, of one order of the projector's image or of two.
TEST_F(TwinFileFringes, FieldOfTheHarmonics) {
  const std::string head = kHead + kCamera +
                           "[fringes]\ndirections = [\"x\", \"y\"]\npitches_px = [64, 16]\nsteps = 8\n"
                           "unwrap = \"hierarchical\"\n";
  const Fringes plain = load(head + "harmonics = [[0.03, 0.04]]\n").fringes;
  EXPECT_FALSE(plain.has_harmonics_field());
  EXPECT_TRUE(plain.directions[0].harmonics_field_sizes().empty());
  const Fringes field =
      load(head + "harmonics = [[0.03, 0.04]]\nharmonics_field = [[[0, -0.01], [0.02, 0]], [[0.03, 0]]]\n")
          .fringes;
  EXPECT_TRUE(field.has_harmonics_field());
  for (const DirectionFringes& d : field.directions) {
    EXPECT_EQ(d.harmonics_field, (std::vector<Harmonics>{{{0.0, -0.01}, {0.02, 0.0}}, {{0.03, 0.0}}}));
    const std::vector<double> sizes = d.harmonics_field_sizes();
    ASSERT_EQ(sizes.size(), 2u);
    EXPECT_NEAR(sizes[0], 0.01 + 0.03, 1e-15);
    EXPECT_NEAR(sizes[1], 0.02, 1e-15);
  }
  EXPECT_EQ(load(head + "harmonics_field = [[[0.125, 0], [0, -0.25]], [[0, 0.5]], [], [], []]\n")
                .fringes.directions[0]
                .harmonics_field,
            (std::vector<Harmonics>{{{0.125, 0.0}, {0.0, -0.25}}, {{0.0, 0.5}}, {}, {}, {}}));
  EXPECT_TRUE(load(head + "harmonics_field = [[[0.1, 0]], []]\n").fringes.has_harmonics());
  EXPECT_FALSE(load(head + "harmonics_field = [[[0, 0]], []]\n").fringes.has_harmonics());
  for (const char* bad : {"[[0.1, 0]]", "[[[0.1, 0]], [], []]", "[[[0.1]], []]", "[[[0.9, 0]], [[0.2, 0]]]"})
    EXPECT_THROW(load(head + "harmonics_field = " + bad + "\n"), UserError) << bad;
}

// A list of pairs per image, from the first order on; images that are no phase steps have none.
TEST_F(TwinFileFringes, HarmonicsOfSingleImages) {
  const std::string head = kHead + kCamera + kProjector +
                           "[fringes]\ndirections = [\"x\"]\npitches_px = [16]\nsteps = 3\n"
                           "unwrap = \"gray\"\n[fringes.gray]\nbits = 2\n",
                    key = "image_harmonics = ";
  const auto text = [&](const std::string& lists) {
    return with(head, "steps", "steps = 3\n" + key + lists);
  };
  EXPECT_FALSE(load(head).fringes.has_image_harmonics());
  const Fringes fringes = load(text("[[], [[-0.25, 0], [0.5, 0.125]], [], [], []]")).fringes;
  EXPECT_TRUE(fringes.has_image_harmonics());
  EXPECT_TRUE(fringes.has_harmonics());
  EXPECT_EQ(fringes.harmonics_of_image(1), (Harmonics{{-0.25, 0.0}, {0.5, 0.125}}));
  EXPECT_TRUE(fringes.harmonics_of_image(0).empty());
  EXPECT_TRUE(fringes.harmonics_of_image(99).empty());
  ASSERT_EQ(fringes.more_harmonics(fringes.directions[0]).size(), 1u);
  EXPECT_EQ(fringes.more_harmonics(fringes.directions[0])[0], std::hypot(0.5, 0.125));
  EXPECT_EQ(fringes.largest_contrast(), 1.5);
  EXPECT_FALSE(load(text("[[], [], [], [], []]")).fringes.has_image_harmonics());
  EXPECT_FALSE(load(text("[]")).fringes.has_image_harmonics());
  EXPECT_FALSE(load(text("[[], [[0, 0]], [], [], []]")).fringes.has_image_harmonics());
  const auto wrong = [&](const std::string& lists) { return error(text(lists), "image_harmonics"); };
  EXPECT_THAT(wrong("[[], [[0.1, 0]]]"), HasSubstr("has 2 lists of pairs, the sequence has 5 images"));
  EXPECT_THAT(wrong("[[], [], [], [[0.1, 0]], []]"),
              HasSubstr("harmonics of image 3, which is no phase step"));
  EXPECT_THAT(wrong("[[[0.9, 0], [0.2, 0]], [], [], [], []]"), HasSubstr("add up to 1.1 of the full scale"));
  EXPECT_THAT(wrong("[[[0.1]], [], [], [], []]"), HasSubstr("must have 2 numbers, has 1"));
  EXPECT_THAT(error(with(text("[[], [[0.1, 0]], [], [], []]"), "blur_px", "pixel_structure = true"),
                    "image_harmonics"),
              HasSubstr("cannot be combined with pixel_structure"));
}

TEST_F(TwinFileFringes, WavesOfTheRaster) {
  const std::string head = kHead + kCamera + kProjector +
                           "[fringes]\ndirections = [\"x\", \"y\"]\npitches_px = [60]\nsteps = 8\n"
                           "unwrap = \"none\"\n";
  const auto text = [&](const std::string& inner) { return head + "raster = { " + inner + " }\n"; };
  EXPECT_FALSE(load(head).fringes.has_raster());
  EXPECT_FALSE(load(text("first = 41, waves = [[0, 0]]")).fringes.has_raster());
  const Fringes fringes = load(text("pitch_px = 1.25, first = 41, waves = [[0.25, 0], [0, -0.5]]")).fringes;
  EXPECT_TRUE(fringes.has_raster());
  for (const DirectionFringes& d : fringes.directions)
    EXPECT_EQ(d.raster, (Raster{1.25, 41, {{0.25, 0.0}, {0.0, -0.5}}}));
  EXPECT_EQ(fringes.directions[0].raster.turns_taken(41, 60.0), 1.0);  // 41 1.25/60 = 0.85
  EXPECT_EQ(fringes.directions[0].raster.turns_taken(20, 60.0), 0.0);
  const Fringes one = load(head + "[fringes.y]\nraster = { first = 9, waves = [[0.25, 0]] }\n").fringes;
  EXPECT_FALSE(one.directions[0].raster.has_any());
  EXPECT_EQ(one.directions[1].raster, (Raster{1.0, 9, {{0.25, 0.0}}}));
  EXPECT_THAT(error(text("waves = [[0.1, 0]]"), "raster"), HasSubstr("is missing"));
  EXPECT_THAT(error(text("first = 41"), "raster"), HasSubstr("must be a list of pairs"));
  EXPECT_THAT(error(text("first = 41, waves = []"), "waves"), HasSubstr("must be a list of pairs"));
  EXPECT_THAT(error(text("first = 1, waves = [[0.1, 0]]"), "first"), HasSubstr("2"));
  EXPECT_THAT(error(text("first = 41, waves = [[0.9, 0], [0.2, 0]]"), "waves"), HasSubstr("add up to 1.1"));
  EXPECT_THAT(error(text("pitch_px = 0, first = 41, waves = [[0.1, 0]]"), "pitch_px"), HasSubstr("0.1"));
}

// A contrast for all pitches, for each, and of one direction alone; out of range, or not one per pitch.
TEST_F(TwinFileFringes, ContrastOfTheFringes) {
  const std::string head = kHead + kCamera +
                           "[fringes]\ndirections = [\"x\", \"y\"]\npitches_px = [64, 16]\nsteps = 8\n"
                           "unwrap = \"hierarchical\"\n";
  const Fringes none = load(head).fringes;
  EXPECT_FALSE(none.has_contrast());
  EXPECT_EQ(none.directions[0].contrast_of(1), 1.0);
  EXPECT_FALSE(load(head + "contrast = 1\n").fringes.has_contrast());
  const Fringes each = load(head + "contrast = 0.75\n[fringes.y]\ncontrast = [1, 0.5]\n").fringes;
  EXPECT_TRUE(each.has_contrast());
  EXPECT_EQ(each.directions[0].contrast, (std::vector<double>{0.75, 0.75}));
  EXPECT_EQ(each.directions[1].contrast, (std::vector<double>{1.0, 0.5}));
  for (const char* bad : {"0", "2.5", "[1]", "[1, -0.5]", "\"much\""})
    EXPECT_THROW(load(head + "contrast = " + bad + "\n"), UserError) << bad;
}

TEST_F(TwinFileFringes, BlurFieldOfTheProjector) {
  const std::string head = kHead + kCamera + kFringes;
  EXPECT_FALSE(load(head + kProjector).projector->has_blur_field());
  const Projector p =
      *load(head + with(kProjector, "blur_px", "blur_px = 1\nblur_field_px2 = [0.1, 0, 1, 0, -0.5]"))
           .projector;
  EXPECT_EQ(p.blur_field_px2, (std::array<double, 5>{0.1, 0.0, 1.0, 0.0, -0.5}));
  const double right = p.lens.width() - 0.5, top = -0.5, middle = 0.5 * (p.lens.height() - 1);
  EXPECT_NEAR(p.blur_variance_px2({right, middle}), 1.0 + 0.1 + 1.0, 1e-12);
  EXPECT_NEAR(p.blur_variance_px2({right, top}), 1.0 + 0.1 + 1.0 - 0.5, 1e-12);
  EXPECT_NEAR(p.least_blur_px(), std::sqrt(0.5 - 0.0025), 1e-3);  // at u = -0.05, v = 1
  const auto wrong = [&](const std::string& lines) {
    return error(head + with(kProjector, "blur_px", "blur_px = 1\n" + lines), "blur_field_px2");
  };
  EXPECT_THAT(wrong("blur_field_px2 = [0, 0, 0, 0]"), HasSubstr("must have 5 numbers, has 4"));
  EXPECT_THAT(wrong("blur_field_px2 = [0, 0, -1, 0, 0]"), HasSubstr("leaves no blur somewhere"));
  EXPECT_THAT(wrong("pixel_structure = true\nblur_field_px2 = [0, 0, 1, 0, 0]"),
              HasSubstr("cannot be combined with pixel_structure"));
}

TEST_F(TwinFileFringes, HaloOfTheProjector) {
  const std::string head = kHead + kCamera + kFringes;
  const auto halo = [&](const std::string& pairs) {
    return *load(head + with(kProjector, "blur_px", "blur_px = 0.5\nhalo = " + pairs)).projector;
  };
  EXPECT_FALSE(load(head + kProjector).projector->has_halo());
  EXPECT_FALSE(halo("[]").has_halo());
  EXPECT_FALSE(halo("[[0.1, 0]]").has_halo());
  EXPECT_EQ(halo("[[0, 3]]").halo_attenuation(0.1), 1.0);
  const Projector p = halo("[[0.2, 1.5], [0.1, 40]]");
  ASSERT_EQ(p.halo.size(), 2u);
  EXPECT_EQ(p.halo[1].share, 0.1);
  EXPECT_EQ(p.halo[1].sigma_px, 40.0);
  EXPECT_EQ(p.halo_attenuation(0.0), 1.0);
  EXPECT_NEAR(p.halo_attenuation(1e3), 0.7, 1e-12);
  const auto wrong = [&](const std::string& lines) {
    return error(head + with(kProjector, "blur_px", lines), "halo");
  };
  EXPECT_THAT(wrong("halo = [[0.2, 1.5]]"), HasSubstr("goes with a blur, and there is none"));
  EXPECT_THAT(wrong("blur_px = 1\nhalo = [[0.6, 1.5], [0.6, 9]]"), HasSubstr("whose sum is 1.2"));
  EXPECT_THAT(wrong("blur_px = 1\nhalo = [[0.1, 1], [0.1, 2], [0.1, 3], [0.1, 4], [0.1, 5]]"),
              HasSubstr("has 5 parts"));
  EXPECT_THAT(wrong("blur_px = 1\nhalo = [[-0.1, 1]]"), HasSubstr("halo"));
  EXPECT_THAT(wrong("blur_px = 1\nhalo = [0.1, 1]"), HasSubstr("halo"));
  EXPECT_THAT(wrong("blur_px = 1\nhalo = [[[0.1, 1]], [[0.1, 2]]]"), HasSubstr("lists within lists"));
  EXPECT_THAT(wrong("blur_px = 1\npixel_structure = true\npixel_fill = 0.9\nhalo = [[0.1, 1]]"),
              HasSubstr("pixel_fill below 1"));
}

TEST_F(TwinFileFringes, LightFieldOfTheProjector) {
  const std::string head = kHead + kCamera + kFringes;
  const auto field = [&](const std::string& numbers) {
    return *load(head + with(kProjector, "blur_px", "light_field = " + numbers)).projector;
  };
  EXPECT_FALSE(load(head + kProjector).projector->has_light_field());
  EXPECT_FALSE(field("[0, 0]").has_light_field());
  EXPECT_TRUE(field("[0, 0.1]").has_light_field());
  const Projector p = field("[0.1, 0, -0.5, 0, 0.25]");
  EXPECT_EQ(p.light_field, (std::vector<double>{0.1, 0.0, -0.5, 0.0, 0.25}));
  EXPECT_EQ(p.light_field_term(4), 0.25);
  EXPECT_EQ(p.light_field_term(13), 0.0);
  EXPECT_EQ(field("[0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.25]").light_field_term(13), 0.25);
  const auto wrong = [&](const std::string& numbers) {
    return error(head + with(kProjector, "blur_px", "light_field = " + numbers), "light_field");
  };
  EXPECT_THAT(wrong("[0.1, 0, 0]"), HasSubstr("has 3 numbers"));
  EXPECT_THAT(wrong("[0.1, 0, 0]"), HasSubstr("give 2, 5, 9 or 14"));
  EXPECT_THAT(wrong("[0.1, 60]"), HasSubstr("<= 50, is 60"));
  EXPECT_THAT(wrong("0.1"), HasSubstr("light_field"));
}

TEST_F(TwinFileFringes, LampOfTheRoom) {
  const std::string with_projector = kHead + kCamera + kProjector + kFringes;
  EXPECT_FALSE(load(with_projector).room.has_lamp());
  EXPECT_FALSE(load(with_projector + "[room]\nlamp = [0, 0, 0]\n").room.has_lamp());
  const Room room = load(with_projector + "[room]\nlamp = [0.5, 0, -1]\n").room;
  EXPECT_TRUE(room.has_lamp());
  EXPECT_EQ(room.lamp_world, Eigen::Vector3d(0.5, 0.0, -1.0));
  const auto wrong = [&](const std::string& line) { return error(with_projector + "[room]\n" + line, line); };
  EXPECT_THAT(wrong("lamp = [1, 2]\n"), HasSubstr("must have 3 numbers, has 2"));
  EXPECT_THAT(wrong("lamb = [1, 2, 3]\n"), HasSubstr("did you mean \"lamp\"?"));
  EXPECT_THAT(error(kHead + kCamera + kFringes + "[room]\nlamp = [0, 0, -1]\n", "lamp"),
              HasSubstr("has no effect without [projector]"));
}

TEST_F(TwinFileFringes, WaveformOfTheFringes) {
  const std::string head = kHead + kCamera + kFringes;
  const auto waveform = [&](const std::string& value) {
    return load(with(head, "steps", "steps = 4\nwaveform = " + value)).fringes.waveform;
  };
  EXPECT_EQ(load(head).fringes.waveform, Waveform{});
  EXPECT_EQ(waveform("\"sine\""), Waveform{});
  EXPECT_EQ(waveform("\"binary\""), (Waveform{Waveform::Kind::levels, {1.0, 0.0, 0.0, 1.0}}));
  EXPECT_EQ(waveform("{ table = [1, 0.25] }"), (Waveform{Waveform::Kind::table, {1.0, 0.25}}));
  EXPECT_EQ(waveform("{ levels = [0, 1, 1] }"), (Waveform{Waveform::Kind::levels, {0.0, 1.0, 1.0}}));
}

}  // namespace
}  // namespace fringetwin::testing::twin_file_fringes_test
