// SPDX-License-Identifier: Apache-2.0
// The whole twin: what twin.toml says (docs/formats/twin.md), read and checked, and the meshes it names.
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "twin/camera_response.hpp"
#include "twin/exposure_timing.hpp"
#include "twin/fringes.hpp"
#include "twin/image/image.hpp"
#include "twin/lens/lens.hpp"
#include "twin/lens/pose.hpp"
#include "twin/mesh/mesh.hpp"
#include "twin/mosaic_channel.hpp"
#include "twin/number/number_range.hpp"
#include "twin/pixel_map.hpp"
#include "twin/shape/shape.hpp"

namespace fringetwin {

// Below settings that are a table of twin.toml, list_keys() names all keys of the table to keys(...): what is
// a plain number or switch with the member it sets and its range, and needs no more than that; the others
// alone. twin/file/ reads them (plain_keys.hpp).

struct Sensor {
  int bit_depth = 8;  ///< 8...16
  std::optional<double> exposure_ms;
  double gain_dn = 1.0;  ///< photoelectric gain coefficient, DN per unit irradiance: slope at the origin
  double black_level_dn = 0.0;
  std::optional<double> electrons_per_dn;  ///< shot noise on when given
  std::optional<double> read_noise_dn;
  CameraResponse response = {};        ///< of the signal gain_dn E, before black level and noise
  PixelMap prnu = {};                  ///< factor of each pixel's gain_dn, mean 1
  PixelMap dsnu = {};                  ///< what each pixel has more than black_level_dn, DN
  bool black_level_is_stated = false;  ///< whether the twin's file has the key: a 0 there is known to be 0
  double max_dn() const { return static_cast<double>((1 << bit_depth) - 1); }
  bool has_noise() const { return electrons_per_dn.has_value() || read_noise_dn.value_or(0.0) > 0.0; }
  bool has_maps() const { return prnu.values || dsnu.values; }
  /// Returns whether all pixels give gray values that are the same straight line of the light.
  bool straight() const { return response.straight() && !has_maps(); }
};
template <class Keys>
void list_keys(Keys& keys, const Sensor*) {
  keys("bit_depth", &Sensor::bit_depth, 8, 16);
  keys("exposure_ms", &Sensor::exposure_ms, NumberRange::positive());
  keys("gain_dn", &Sensor::gain_dn, NumberRange::positive());
  keys("black_level_dn");
  keys("electrons_per_dn", &Sensor::electrons_per_dn, NumberRange::positive());
  keys("read_noise_dn", &Sensor::read_noise_dn, NumberRange::not_negative());
  keys("response"), keys("prnu"), keys("dsnu");
  keys("mosaic"), keys("channel");  // of the camera: they say which pixels its image has
}

/// Thin lens; the aperture diameter is focal_length_mm / f_number, the focus plane lies at camera
/// z = focus_distance_mm.
struct Optics {
  double f_number = 0.0;
  double focal_length_mm = 0.0;
  double focus_distance_mm = 0.0;
};

/// Light or gain that varies over the camera's image: falling towards the corners, or to one side.
struct Vignetting {
  enum class Kind { none, cos4, polynomial };
  Kind kind = Kind::none;
  /// polynomial: 1 + tilt_x u + tilt_y v + a1 r^2 + a2 r^4 + a3 r^6; (u, v) from the image's middle, to the
  /// right and down, r^2 = u^2 + v^2 = 1 at its corners.
  std::array<double, 3> a{};
  std::array<double, 2> tilt{};
};

/// Returns the factor of an image out of a list with one for each image of the sequence, 1 of an empty list.
inline double factor_of(const std::vector<double>& factors, std::size_t image) {
  return factors.empty() ? 1.0 : factors.at(image);
}

/// What each pixel of a camera makes of the light that it gets: factor * light + offset. Of the camera's
/// size, or empty: 1 and 0.
struct PixelTexture {
  ImageF factor, offset;  ///< offset: irradiance, light of the room that is exposed as the other is
  double factor_at(std::size_t pixel) const {
    return factor.empty() ? 1.0 : static_cast<double>(factor.data[pixel]);
  }
  double offset_at(std::size_t pixel) const {
    return offset.empty() ? 0.0 : static_cast<double>(offset.data[pixel]);
  }
  /// Returns the light of a pixel with this texture; `exposure`: factor of the image, which `light` has
  /// already.
  float of(float light, std::size_t pixel, double exposure) const {
    return static_cast<float>(factor_at(pixel) * static_cast<double>(light) + exposure * offset_at(pixel));
  }
};

struct Camera {
  std::string name;
  Lens lens;  ///< of the image: with a channel, twin.toml gives that of the whole sensor
  Pose T_cam_world;
  Sensor sensor;
  std::optional<Optics> optics;
  double psf_px = 0.0;  ///< Gaussian sigma of the lens's point spread, px of the sensor
  /// How far a pixel of the image reaches, as standard deviation along an axis: with it a texture that
  /// changes within a pixel moves its fringes; 0: a factor of each pixel moves none.
  double texture_spread_px = 0.0;
  Vignetting vignetting = {};
  /// Of each image of the sequence: what its exposure makes of all light; empty: 1.
  std::vector<double> exposure_factors = {};
  /// When exposures begin and end beside the patterns; without, each sees the whole of its own alone, and
  /// objects that move stand still meanwhile.
  std::optional<ExposureTiming> timing = std::nullopt;
  std::filesystem::path texture_file = {};                ///< an EXR; empty: none
  std::shared_ptr<const PixelTexture> texture = nullptr;  ///< filled by load_meshes()
  /// The colour of a colour sensor whose pixels are the image; empty: all pixels are.
  std::optional<MosaicChannel> channel = std::nullopt;
  Eigen::Vector3d center_world_mm() const { return T_cam_world.inverse().translation_mm; }
  /// Returns the side of a pixel of the sensor, in pixels of the image.
  double pixel_side_px() const { return channel ? 0.5 : 1.0; }
  /// Returns whether light reaches the image's pixels over others of the sensor, which must be rendered, too.
  bool spreads_over_sensor() const { return channel && psf_px > 0.0; }
  /// Returns the width and height of the whole sensor.
  Eigen::Vector2i sensor_px() const {
    return channel ? channel->sensor_px : Eigen::Vector2i(lens.width(), lens.height());
  }
  /// Returns the whole sensor's place of a place of the image.
  Eigen::Vector2d on_sensor_px(const Eigen::Vector2d& q_px) const {
    return channel ? sensor_place_px(*channel, q_px) : q_px;
  }
  /// Returns where the image's rows lie on the sensor.
  RowHeights row_heights() const {
    if (timing && timing->rows) return *timing->rows;
    const double first_px = on_sensor_px({0.0, 0.0}).y(), second_px = on_sensor_px({0.0, 1.0}).y(),
                 height_px = sensor_px().y();
    return {(first_px + 0.5) / height_px - 0.5, (second_px - first_px) / height_px};
  }
  /// Returns the lens of the whole sensor, as twin.toml gives it.
  Lens whole_lens() const { return channel ? sensor_lens(lens, *channel) : lens; }
};
template <class Keys>
void list_keys(Keys& keys, const Camera*) {
  keys("name"), keys("sensor"), keys("optics");
  keys("psf_px", &Camera::psf_px, NumberRange::between(0.0, 20.0));
  keys("texture_spread_px", &Camera::texture_spread_px, NumberRange::between(0.0, 20.0));
  keys("vignetting"), keys("vignetting_tilt"), keys("exposure_factors"), keys("texture");
  keys("timing");
}

template <class Keys>
void list_keys(Keys& keys, const ExposureTiming*) {
  keys("exposure", &ExposureTiming::exposure,
       NumberRange{.min = 0.0, .max = 1.0, .min_excluded = true, .smallest = 1e-3});
  keys("read_out", &ExposureTiming::read_out, NumberRange::between(0.0, 1.0));
  keys("late");
}

struct ProjectorResponse {
  enum class Kind { linear, gamma, table };
  Kind kind = Kind::linear;
  double gamma = 1.0;
  std::vector<double> table;  ///< >= 2 equally spaced levels 0...1, linear interpolation
  double operator()(double value) const;
};

/// Orders (i, j) of the terms of Projector::light_field, up to the fourth.
using LegendreOrders = std::array<unsigned, 2>;
inline constexpr std::array kLightFieldTerms{LegendreOrders{1, 0}, LegendreOrders{0, 1}, LegendreOrders{2, 0},
                                             LegendreOrders{1, 1}, LegendreOrders{0, 2}, LegendreOrders{3, 0},
                                             LegendreOrders{2, 1}, LegendreOrders{1, 2}, LegendreOrders{0, 3},
                                             LegendreOrders{4, 0}, LegendreOrders{3, 1}, LegendreOrders{2, 2},
                                             LegendreOrders{1, 3}, LegendreOrders{0, 4}};

inline constexpr std::size_t kMostHalos = 4;  ///< parts of a halo
inline constexpr double kWidestHaloPx = 1e4;  ///< of a part
/// A part of the projector's light that its lens, or the air, spreads further than its blur.
struct Halo {
  double share = 0.0;     ///< of all light
  double sigma_px = 0.0;  ///< Gaussian sigma that this part is blurred by, besides the blur; projector px
};

struct Projector {
  Lens lens;
  Pose T_proj_world;
  double intensity = 1.0;
  bool inverse_square = false;  ///< falloff (d0/d)^2, d = distance to the projector centre
  double reference_distance_mm = 0.0;
  double blur_px = 0.0;  ///< Gaussian sigma, projector px, applied after the response
  ProjectorResponse response;
  double ambient = 0.0;                         ///< irradiance added wherever an object is hit
  std::optional<Optics> optics = std::nullopt;  ///< thin lens: defocus by depth
  /// The pattern is constant over each projector pixel: the value at its centre.
  bool pixel_structure = false;
  /// Side of the pixel's square that gives light, with pixel_structure; the mean is kept.
  double pixel_fill = 1.0;
  std::optional<int> quantise_bits = std::nullopt;  ///< of the frame buffer, with pixel_structure
  /// What the blur's variance has more at (u, v) than in the middle, px^2: b0 u + b1 v + b2 u^2 + b3 uv +
  /// b4 v^2, u and v from -1 to 1 across the projector's image.
  std::array<double, 5> blur_field_px2 = {};
  /// Light that is spread further than the blur: the tails of the projector's point spread.
  std::vector<Halo> halo = {};
  /// ln of the light at a place of the projector's image over its geometric mean there: the sum of these
  /// times Legendre's P_i(u) P_j(v), (i, j) as in kLightFieldTerms, u and v from -1 to 1 across the image;
  /// missing ones are 0.
  std::vector<double> light_field = {};
  /// Of each image of the sequence (a lamp that flickers or drifts): the projector's light, and the ambient
  /// light; empty: 1.
  std::vector<double> light_factors = {}, ambient_factors = {};
  /// Of each image of the sequence (vibration, wrong phase steps): by how much its pattern lies further along
  /// its axis; empty: 0.
  std::vector<double> image_shifts_px = {};
  Eigen::Vector3d center_world_mm() const { return T_proj_world.inverse().translation_mm; }
  bool has_blur_field() const { return blur_field_px2 != std::array<double, 5>{}; }
  /// Returns the shift of an image of the sequence.
  double image_shift_px(std::size_t image) const {
    return image < image_shifts_px.size() ? image_shifts_px[image] : 0.0;
  }
  bool has_image_shifts() const {
    return std::ranges::any_of(image_shifts_px, [](double px) { return px != 0.0; });
  }
  /// A part without a share counts: a fit begins there, and a code is rendered by one method all along.
  bool has_halo() const {
    return std::ranges::any_of(halo, [](const Halo& h) { return h.sigma_px != 0.0; });
  }
  /// Returns what the halo leaves of a wave of light, besides what the blur does: the Fourier transform of
  /// (1 - sum of shares) delta + sum of share_i Gaussian_i.
  double halo_attenuation(double cycles_per_px) const;
  bool has_light_field() const {
    return std::ranges::any_of(light_field, [](double c) { return c != 0.0; });
  }
  /// Returns the terms of the fields (light_field, DirectionFringes::harmonics_field) up to the second order
  /// at a place of the projector's image.
  std::array<double, kHarmonicsFieldTerms> field_terms(const Eigen::Vector2d& q_px) const;
  double light_field_term(std::size_t k) const { return k < light_field.size() ? light_field[k] : 0.0; }
  /// Returns the variance of the blur at a place of the projector's image; 0 at least.
  double blur_variance_px2(const Eigen::Vector2d& q_px) const;
  /// Returns the smallest blur over the image.
  double least_blur_px() const;
};
template <class Keys>
void list_keys(Keys& keys, const Projector*) {
  keys("intensity", &Projector::intensity, NumberRange::positive());
  keys("falloff"), keys("reference_distance_mm");
  keys("blur_px", &Projector::blur_px, NumberRange{.min = 0.0, .largest = 1e4});
  keys("blur_field_px2"), keys("halo"), keys("light_field"), keys("response");
  keys("ambient", &Projector::ambient, NumberRange::not_negative());
  keys("optics");
  keys("pixel_structure", &Projector::pixel_structure);
  keys("pixel_fill", &Projector::pixel_fill,
       NumberRange{.min = 0.0, .max = 1.0, .min_excluded = true, .smallest = 0.01});
  keys("quantise_bits", &Projector::quantise_bits, 1, 16);
  keys("light_factors"), keys("ambient_factors"), keys("image_shifts_px");
}

/// Of Material::mean_free_path_mm.
inline constexpr double kLongestFreePathMm = 100.0;

struct Material {
  double diffuse = 0.8;
  double specular = 0.0;
  double shininess = 10.0;
  enum class Specular { phong, ggx };
  Specular specular_model = Specular::phong;
  double roughness = 0.5;  ///< ggx: alpha = roughness^2; `specular` is the reflectance at normal incidence
  /// How far light goes below the surface between two changes of its direction, on average; 0: the diffuse
  /// light leaves where it came in.
  double mean_free_path_mm = 0.0;
};
template <class Keys>
void list_keys(Keys& keys, const Material*) {
  keys("diffuse", &Material::diffuse, NumberRange::between(0.0, 1.0));
  keys("specular", &Material::specular, NumberRange::not_negative());
  keys("shininess", &Material::shininess, NumberRange::positive());
  keys("mean_free_path_mm", &Material::mean_free_path_mm, NumberRange::between(0.0, kLongestFreePathMm));
  keys("specular_model"), keys("roughness");
}

struct Object {
  std::string name;
  Shape shape;
  Material material;
  /// By how far each of the shape's motions() goes at constant speed from the first image of the sequence to
  /// the last (moving.hpp); empty: at rest.
  std::vector<double> motion = {};
};

/// Light of the room that is not the same everywhere, besides Projector::ambient, whose factors it has.
struct Room {
  /// Points to a lamp so far away that its light comes from one direction; its length is the irradiance that
  /// a white surface (diffuse = 1) shows which faces the lamp. Diffuse light only, shadowed by the objects.
  Eigen::Vector3d lamp_world = Eigen::Vector3d::Zero();
  bool has_lamp() const { return lamp_world != Eigen::Vector3d::Zero(); }
};
template <class Keys>
void list_keys(Keys& keys, const Room*) {
  keys("lamp");
}

/// Of RenderOptions::bounces: as long as light is left, "all" in a file; and the largest number in a file.
inline constexpr int kAllBounces = 1000, kMostBounces = 100;

enum class Sampler { gauss, multi_jittered, sobol, adaptive };

struct RenderOptions {
  double pixel_fill = 1.0;  ///< side of the sampled square, px of the sensor
  double phase_error_rad = 1e-4;
  double gray_error = 1e-4;    ///< rms over all pixels, fraction of the sensor's full scale
  std::optional<int> samples;  ///< fixed sampling when given
  std::optional<Sampler> sampler;
  bool shadow = true;  ///< false: nothing hides a point from the projector
  /// Over how many other surfaces light of the projector may come before the one that is seen.
  int bounces = 0;
  int bounce_samples = 256;  ///< directions of each place that gathers light over others
  /// Such light may leave the first and the last of its surfaces by their lobes, too.
  bool glossy_bounces = false;
};
template <class Keys>
void list_keys(Keys& keys, const RenderOptions*) {
  keys("pixel_fill", &RenderOptions::pixel_fill, NumberRange{.min = 0.0, .max = 2.0, .min_excluded = true});
  keys("phase_error_rad", &RenderOptions::phase_error_rad, NumberRange::positive(1e-8, 1.0));
  keys("gray_error", &RenderOptions::gray_error, NumberRange::positive());
  keys("samples", &RenderOptions::samples, 1, 65536);
  keys("sampler");
  keys("shadow", &RenderOptions::shadow);
  keys("bounces");
  keys("bounce_samples", &RenderOptions::bounce_samples, 2, 65536);
  keys("glossy_bounces", &RenderOptions::glossy_bounces);
}

enum class Triangulate { stereo, projector };

struct FitRequest {
  std::string object;
  double gate_mm = 2.0;
};
struct MeasureOptions {
  std::optional<Triangulate> triangulate;  ///< default: stereo with two cameras, else projector
  double min_modulation_dn = 5.0;
  double smoothing_px = 0.0;        ///< radius of the local fit of coordinates before triangulation; 0 = off
  bool correct_light = false;       ///< light = "corrected": factors of the images are taken out first
  bool correct_pixel_area = false;  ///< fits are stated without their bias (measure/fit/method_bias.hpp)
  std::vector<FitRequest> fits;
};

/// What is dealt to the folds of held-out images.
enum class HeldOutBy { steps, pitches };

/// How the two sides are compared.
struct ComparisonOptions {
  int hold_out = 0;  ///< folds that the images are dealt to, each predicted from the others; 0 = none
  HeldOutBy hold_out_by = HeldOutBy::steps;
};

/// A published physical result where no images exist. Keys as in result.json fits.
struct PublishedFit {
  std::string object;
  std::map<std::string, double> numbers;           ///< radius_mm, rms_mm, ...
  std::map<std::string, Eigen::Vector3d> vectors;  ///< center_mm, point_mm, normal, axis
};
struct RealSource {
  std::optional<std::filesystem::path> captures;  ///< folder with a capture.toml; resolved
  std::vector<PublishedFit> results;
  std::string results_source;  ///< where the published numbers come from
};

struct Twin {
  std::string name;
  std::filesystem::path file;  ///< the twin.toml; relative paths start here
  std::vector<Camera> cameras;
  std::optional<Projector> projector;
  Fringes fringes;
  std::vector<Object> objects;
  Room room = {};
  RenderOptions render;
  MeasureOptions measure;
  ComparisonOptions compare;
  RealSource real;
  std::optional<std::filesystem::path> calibration_uncertainty;  ///< a calibration.json; resolved
  std::map<std::string, double> limits;                          ///< name -> limit; names: docs/FORMATS.md
  std::vector<std::filesystem::path> input_files;                ///< every file read, for inputs_sha256

  const Object* find_object(const std::string& name) const;
  /// Returns whether light goes below the surface of any object.
  bool has_subsurface() const;
  /// Returns how the rig triangulates: what the file says, else its default.
  Triangulate triangulate() const;
  /// Returns the side of the square that a pixel of the camera's image gathers light from, px of the image.
  double sampled_side_px(const Camera& camera) const { return render.pixel_fill * camera.pixel_side_px(); }
};

/// Returns the twin.toml of a folder; what is no folder as it is. Throws UserError(usage) of a folder that
/// has none.
std::filesystem::path twin_file_of(const std::filesystem::path& file_or_folder);

/// Reads and checks a twin.toml, for which its folder may stand. Throws UserError(usage) with file, line and
/// key; unknown keys name the nearest known one. ${FRINGETWIN_CAPTURES} in a path is replaced by that
/// environment variable (default: ../shared/captures beside the project's checkout).
Twin load_twin(const std::filesystem::path& file);
/// The same with values (TOML text) put in the place of some keys before anything is checked; the file stays
/// as it is. Paths of keys: "camera.left.sensor.bit_depth" (cameras, objects, fits by name or as
/// "camera[0]"), "fringes.pitches_px[0]". A path that leads nowhere is an UnknownKey.
Twin load_twin(const std::filesystem::path& file, const std::map<std::string, std::string>& settings);

/// Loads the files of all MeshShapes, albedo maps, textures of cameras and maps of sensors that are not there
/// yet; one file is read once and shared. What `known` has read already is taken from there.
void load_meshes(Twin& twin, const Twin* known = nullptr);

/// Returns the root of the real captures: $FRINGETWIN_CAPTURES, or shared/captures beside the checkout of a
/// program that lies in its build tree, or beside the working folder's parent.
std::filesystem::path captures_root();
/// Returns the checkout that the running program was built from, while it lies in its build tree; else empty.
std::filesystem::path own_checkout();
/// Returns the folder of the data sets: the checkout's, or share/fringetwin/datasets of an installed program
/// (PREFIX/bin/fringetwin); empty for a program that lies elsewhere.
std::filesystem::path datasets_root();

}  // namespace fringetwin
