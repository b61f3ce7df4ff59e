// SPDX-License-Identifier: Apache-2.0
// `fringetwin photometry` as a user runs it: a rendered rig comes back from its own captures, what it writes
// is what a twin reads, and faults end in one sentence with nothing written.
//
// | check                            | tolerance         | origin                              |
// |----------------------------------|-------------------|-------------------------------------|
// | gain, read noise, gamma, blur    | 4 sigma           | put into the twin; its own sigma    |
// | largest sigma: gain, gamma, blur | 8 %, 0.03, 0.1 px | what so small a rig can tell        |
// | rms of pixels                    | 5 %, 3 %          | 19,200 pixels: 0.5 %; the light around each is |
// |                                  |                   | told by 961 of them, fewer at borders: 0.3 %   |
// | offset of one pixel              | 5 sigma           | 1 DN and rounding, of 16 images                |
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "tests/support/program/small_twin.hpp"
#include "twin/image/image_io.hpp"
#include "twin/twin.hpp"

namespace fringetwin::testing::photometry_test {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

/// A tilted board that fills the image; smooth gamma and blur, a sensor with shot noise.
std::string rig() {
  return small_twin(
      {{"gain_dn = 20", "gain_dn = 20\nblack_level_dn = 10\nelectrons_per_dn = 30\nread_noise_dn = 0.8"},
       {"intensity = 40", "intensity = 40\nresponse = { gamma = 1.9 }\nblur_px = 3.0"},
       {"pitches_px = [13, 14, 15]\nsteps = 4", "pitches_px = [120, 30, 15]\nsteps = 8\nunwrap = \"none\""},
       {"shape = \"sphere\"\ncenter_mm = [0, 0, 270]\nradius_mm = 19",
        "shape = \"plane\"\npoint_mm = [0, 0, 270]\nnormal = [0.6, 0.5, -1]"},
       {"[measure]\ntriangulate = \"projector\"\n[[measure.fit]]\nobject = \"ball\"\n", ""}});
}

std::string replaced(std::string text, const std::vector<std::pair<std::string, std::string>>& pairs) {
  for (const auto& [from, to] : pairs) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    if (at != std::string::npos) text.replace(at, from.size(), to);
  }
  return text;
}

/// Returns the line of a key as photometry.toml has it, and its value without the comment.
std::string line_of(const std::string& text, const std::string& key) {
  const auto at = text.find("\n" + key + " = ") + 1;
  return text.substr(at, text.find('\n', at) - at);
}
std::string value_of(const std::string& text, const std::string& key) {
  const std::string line = line_of(text, key);
  const auto end =
      line.find('#') == std::string::npos ? line.size() : line.find_last_not_of(' ', line.find('#') - 1) + 1;
  return line.substr(key.size() + 3, end - key.size() - 3);
}

RunResult photometry(const fs::path& dir, std::vector<std::string> more) {
  more.insert(more.begin(), {"photometry", (dir / "twin.toml").string(), "--out", (dir / "found").string()});
  return run_fringetwin(more);
}

TEST(PhotometryCommand, ARenderedRigComesBack) {
  FT_NEED_DEVICE();
  const fs::path dir = scratch_folder("photometry");
  ASSERT_EQ(render_twin(rig(), dir).exit_code, 0);
  const std::string mine = replaced(rig(), {{"electrons_per_dn = 30", "electrons_per_dn = 99 # data sheet"},
                                            {"\nread_noise_dn = 0.8", ""},
                                            {"blur_px = 3.0", "blur_px=0.5  # a guess"}});
  write_file(dir / "mine.toml", mine);
  const RunResult run =
      photometry(dir, {"--captures", (dir / "out").string(), "--into", (dir / "mine.toml").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("from phase steps"));
  const auto json = read_json(dir / "found" / "photometry.json");
  EXPECT_EQ(json["schema"].get<std::string>(), "fringetwin-photometry/1");
  const auto& transfer = json["cameras"][0]["photon_transfer"];
  const auto near = [](const nlohmann::json& table, const char* name, const char* sigma, double truth,
                       double largest) {
    const double value = table[name], s = table[sigma];
    EXPECT_LT(std::abs(value - truth), 4.0 * s) << name << " " << value << " +- " << s;
    EXPECT_LT(s, largest) << name;
  };
  near(transfer, "electrons_per_dn", "electrons_per_dn_sigma", 30.0, 2.4);
  near(transfer, "read_noise_dn", "read_noise_sigma_dn", 0.8, 0.05);
  const auto& projector = json["cameras"][0]["projector"][0];
  near(projector["response"], "gamma", "gamma_sigma", 1.9, 0.03);
  near(projector, "blur_px", "blur_sigma_px", 3.0, 0.1);
  EXPECT_THAT(read_file(dir / "found" / "photometry.html"), HasSubstr("Photon transfer"));

  // The twin that they were put into: what was measured, and all else as it was.
  EXPECT_THAT(run.err, HasSubstr("put into " + (dir / "mine.toml").string()));
  const std::string blocks = read_file(dir / "found" / "photometry.toml");
  EXPECT_EQ(read_file(dir / "mine.toml"),
            replaced(mine, {{"electrons_per_dn = 99 #",
                             "electrons_per_dn = " + value_of(blocks, "electrons_per_dn") + " #"},
                            {"[projector]", line_of(blocks, "read_noise_dn") + "\n[projector]"},
                            {"{ gamma = 1.9 }", value_of(blocks, "response")},
                            {"blur_px=0.5", "blur_px=" + value_of(blocks, "blur_px")}}));

  // The blocks under the lenses of a twin.
  std::string toml = read_file(dir / "found" / "photometry.toml");
  const auto put = [&](const std::string& after, const std::string& text) {
    const auto at = toml.find(after);
    ASSERT_NE(at, std::string::npos) << after;
    toml.insert(at + after.size(), text);
  };
  const std::string lens =
      "lensmodel = \"LENSMODEL_PINHOLE\"\nimagersize = [160, 120]\nintrinsics = [260, 260, 79.5, 59.5]\n";
  put("name = \"left\"\n", lens);
  put("[projector]\n", lens + "rt_cam_world = [0, 0, 0, -95, 0, 0]\n");
  write_file(dir / "pasted.toml",
             "schema = \"fringetwin-twin/1\"\n" + toml +
                 "[fringes]\ndirections = [\"x\"]\npitches_px = [16]\nsteps = 4\nunwrap = \"none\"\n");
  const Twin twin = load_twin(dir / "pasted.toml");
  EXPECT_NEAR(*twin.cameras[0].sensor.electrons_per_dn, transfer["electrons_per_dn"], 0.1);
  EXPECT_NEAR(*twin.cameras[0].sensor.read_noise_dn, transfer["read_noise_dn"], 0.01);
  EXPECT_EQ(twin.cameras[0].sensor.black_level_dn, 10.0);
  EXPECT_EQ(twin.projector->response.kind, ProjectorResponse::Kind::gamma);
  EXPECT_NEAR(twin.projector->blur_px, 3.0, 0.4);
}

// Dark and flat images of pixels that differ: the maps that are written are those of a twin that names them,
// which cannot do without them.
TEST(PhotometryCommand, MapsOfPixelsAreWrittenForTheTwin) {
  const fs::path dir = scratch_folder("photometry-maps");
  write_file(dir / "twin.toml", rig());
  std::mt19937 random(5);
  std::normal_distribution<float> normal;
  ImageF factor(160, 120), offset_dn(160, 120);
  for (float& f : factor.data) f = 1.0F + 0.02F * normal(random);
  for (float& o : offset_dn.data) o = 1.5F * normal(random);
  for (int k = 0; k < 16; ++k)
    for (const auto& [name, light_dn] : {std::pair{"dark", 0.0F}, {"flat", 150.0F}}) {
      ImageF image(160, 120);
      for (std::size_t i = 0; i < image.size(); ++i)
        image.data[i] = std::round(20.0F + offset_dn.data[i] + light_dn * factor.data[i] + normal(random));
      write_gray_png(dir / (name + std::to_string(k) + ".png"), image, 8);
    }
  const RunResult run =
      photometry(dir, {"--dark", (dir / "dark*.png").string(), "--flat", (dir / "flat*.png").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("gains of the pixels differ by"));
  const auto camera = read_json(dir / "found" / "photometry.json")["cameras"][0];
  EXPECT_NEAR(camera["prnu"]["rms"].get<double>(), 0.02, 0.001);
  EXPECT_NEAR(camera["dsnu"]["rms_dn"].get<double>(), 1.5, 0.05);
  EXPECT_NEAR(camera["dsnu"]["noise_dn"].get<double>(), std::sqrt(1.0 + 1.0 / 12.0) / 4.0, 0.01);
  EXPECT_EQ(camera["prnu"]["n_images"].get<int>(), 16);
  const std::string toml = read_file(dir / "found" / "photometry.toml");
  EXPECT_THAT(toml, HasSubstr("prnu = \"prnu_left.exr\""));
  EXPECT_THAT(toml, HasSubstr("dsnu = \"dsnu_left.exr\""));
  write_file(dir / "mapped.toml",
             small_twin({{"gain_dn = 20",
                          "gain_dn = 20\nblack_level_dn = 10\nprnu = \"found/prnu_left.exr\"\ndsnu = "
                          "\"found/dsnu_left.exr\""}}));
  Twin twin = load_twin(dir / "mapped.toml");
  load_meshes(twin);
  EXPECT_NEAR(twin.cameras[0].sensor.dsnu.values->data[777], offset_dn.data[777], 5.0 * 0.26);
  fs::remove(dir / "found" / "dsnu_left.exr");
  expect_refused(run_fringetwin({"render", (dir / "mapped.toml").string(), "--out", (dir / "out").string()}),
                 2, {"[camera.sensor] dsnu = ", "dsnu_left.exr", "of camera \"left\""});
}

// Colour images whose green is that of gray ones, with noise in red and blue, tell the same.
TEST(PhotometryCommand, OneColourTellsWhatGrayImagesTell) {
  const fs::path dir = scratch_folder("photometry-colour");
  write_file(dir / "twin.toml", rig());
  std::mt19937 random(24);
  std::normal_distribution<float> normal;
  for (int k = 0; k < 4; ++k) {
    ImageF gray(160, 120);
    std::string colours;
    for (float& value : gray.data) {
      value = std::round(20.0F + normal(random));
      for (const std::uint_fast32_t other :
           {random() % 256, static_cast<std::uint_fast32_t>(value), random() % 256})
        colours += static_cast<char>(other);
    }
    write_gray_png(dir / ("gray" + std::to_string(k) + ".png"), gray, 8);
    write_file(dir / ("colour" + std::to_string(k) + ".ppm"), "P6 160 120 255\n" + colours);
  }
  const auto cameras_of = [&](const std::string& glob, std::vector<std::string> more) {
    more.insert(more.begin(), {"--dark", (dir / glob).string()});
    const RunResult run = photometry(dir, more);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return read_json(dir / "found" / "photometry.json")["cameras"];
  };
  EXPECT_EQ(cameras_of("colour*.ppm", {"--channel", "green"}), cameras_of("gray*.png", {}));
  expect_refused(photometry(dir, {"--dark", (dir / "colour*.ppm").string()}), 3,
                 {"colour0.ppm: is a colour image (3 channels)", "photometry: --channel green"});
}

TEST(PhotometryCommand, FaultsEndInOneSentence) {
  const fs::path dir = scratch_folder("photometry-bad");
  write_file(dir / "twin.toml", rig());
  write_gray_png(dir / "gray.png", ImageF(160, 120, 50.0f), 8);
  write_gray_png(dir / "small.png", ImageF(100, 100, 50.0f), 8);
  const auto refused = [&](const std::vector<std::string>& args, int code,
                           const std::vector<std::string>& parts) {
    expect_refused(photometry(dir, args), code, parts);
    EXPECT_FALSE(fs::exists(dir / "found"));
  };
  const std::string image = (dir / "gray.png").string();
  refused({}, 2, {"photometry: has no images to work on"});
  refused({"--dark", (dir / "none*.png").string()}, 3, {"--dark", "matches no image"});
  refused({"--series", image + "@fast"}, 2, {"the exposure behind @ is no positive number"});
  refused({"--captures", (dir / "nowhere").string()}, 3, {"nowhere"});
  fs::copy_file(image, dir / "cut.png");
  fs::resize_file(dir / "cut.png", 60);
  refused({"--flat", (dir / "cut.png").string()}, 3, {"cut.png"});
  refused({"--flat", (dir / "small.png").string()}, 3,
          {"small.png: is 100 x 100 px, camera \"left\" has 160 x 120"});
  refused({"--series", image}, 3, {"nothing can be told from these images"});
}

}  // namespace
}  // namespace fringetwin::testing::photometry_test
