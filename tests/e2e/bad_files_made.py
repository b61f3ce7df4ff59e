# SPDX-License-Identifier: Apache-2.0
"""Bad files that code makes: what no reader may be given (pipes, devices, endless files), and text formats.

Images and databases: bad_files_binary.py; what the program writes itself: bad_files_records.py. What is wrong with a file its name says.
"""
import math
import os
import random
import shutil

GOOD = {"twin": "twin.toml", "capture_set": "capture.toml", "study": "study.toml", "cameramodel": "left.cameramodel",
        "opencv": "calibration.yml", "kalibr": "camchain.yaml", "matrices": "K.txt", "corners": "corners.vnl",
        "ply": "part.ply", "obj": "part.obj", "stl": "part.stl", "result_json": "result.json", "calibration_json": "calibration.json"}
DEEP = 100_000
SPHERE = 'shape = "sphere"\ncenter_mm = [0, 0, 270]\nradius_mm = 19'  # of the good twin


class Bad:
    """A bad file by its name; `put` makes it at a path."""

    def __init__(self, name, put, suffix="", everywhere=False, may_pass=False, good=False):
        self.name, self.put, self.suffix = name, put, suffix
        self.everywhere = everywhere  # all images of a set are this one
        self.may_pass = may_pass  # only time and memory are asked for
        self.good = good  # must not be refused
        self.shown = None


def text(name, content, suffix="", **more):
    """A file of that content, or of what the call of it gives: a large one is not kept, since the memory of this process
    counts as the program's (bad_files.py, run)."""
    def put(path):
        data = content() if callable(content) else content
        path.write_bytes(data.encode() if isinstance(data, str) else data)
    return Bad(name, put, suffix, **more)


def file_of(file):
    return Bad(file.name, lambda path: shutil.copyfile(file, path), file.suffix)


def sparse(size):
    def put(path):
        with open(path, "wb") as file:
            file.truncate(size)
    return put


def begins(content, size=4 << 30):
    """A file of that size that holds nothing behind its first bytes."""
    def put(path):
        path.write_bytes(content)
        os.truncate(path, size)
    return put


def spirals(count, corners):
    """Polygons in an OBJ of which a long time is taken to cut off each corner."""
    lines = []
    for k in range(count):
        for i in range(corners):
            outwards = i < corners // 2
            turn = 0.3 * (i if outwards else corners - 1 - i)
            radius = 1 + turn + (0 if outwards else 0.5)
            lines.append(f"v {radius * math.cos(turn):.6f} {radius * math.sin(turn):.6f} {270 + k}")
        lines.append("f " + " ".join(str(-corners + i) for i in range(corners)))
    return "\n".join(lines) + "\n"


def good(reader, folder):
    """The good files themselves."""
    names = [GOOD[reader]] if reader in GOOD else []
    if reader == "opencv":
        names += ["calibration.xml", "calibration_of_opencv.json"]
    return [Bad("good_" + name, file_of(folder / name).put, (folder / name).suffix, good=True) for name in names]


def common(reader, folder):
    """What every reader is given; a store and a journal that are not there yet are made, so no missing one for these."""
    noise = random.Random(reader)
    cases = [
        Bad("pipe", os.mkfifo),
        Bad("device_zero", lambda path: os.symlink("/dev/zero", path)),
        Bad("folder", os.mkdir),
        Bad("sparse_100_GB", sparse(100 << 30)),
        text("zeros", lambda: bytes(1 << 20)),
        text("noise", lambda: noise.randbytes(1 << 16)),
        text("utf16", "schema = 1\n".encode("utf-16")),
        text("not_utf8", b"\xff\xfe\x80\xc0\xaf = \xf5\n"),
        text("one_long_line", lambda: "a" * (1 << 20)),
        text("escape_sequences", "\x1b[2J\x1b]0;title\x07\x1b[31m = 1\n{\x1b[31m\n"),
    ]
    if reader != "study_store":  # an empty database is a new one
        cases.append(text("empty", ""))
    if reader not in ("study_store", "journal", "corners"):
        cases.append(Bad("link_to_nothing", lambda path: os.symlink("nowhere", path)))
    if reader in GOOD and reader not in ("matrices", "corners", "obj", "kalibr"):  # whose halves are whole files
        whole = (folder / GOOD[reader]).read_bytes()
        cases.append(text("cut_at_60_percent", whole[:len(whole) * 6 // 10]))
    return cases


def good_text(reader):
    here = os.path.dirname(os.path.abspath(__file__))
    with open(os.path.join(here, "..", "bad_files", "good", GOOD[reader])) as file:
        return file.read()


def edits(reader, table):
    """Cases from (name, what is replaced, by what) in the reader's good file."""
    whole = good_text(reader)
    for name, old, _ in table:
        assert old in whole, f"{reader}/{name}: the good file has no {old}"
    return [text(name, lambda old=old, new=new: whole.replace(old, new, 1)) for name, old, new in table]


def deep_toml(rest):
    return [
        text("dotted_key_100000", ".".join("a" * DEEP) + " = 1\n" + rest),
        text("dotted_header_100000", "[" + ".".join("a" * DEEP) + "]\n" + rest),
        text("nested_arrays_100000", "a = " + "[" * DEEP + "]" * DEEP + "\n" + rest),
        text("nested_tables_100000", "a = " + "{a=" * DEEP + "1" + "}" * DEEP + "\n" + rest),
        text("unknown_key_of_a_megabyte", "k" * (1 << 20) + " = 1\n" + rest),
        text("unknown_key_with_escape_sequence", '"\\u001b[31mred" = 1\n' + rest),
        text("unknown_keys_100000", "".join(f"k{i} = {i}\n" for i in range(DEEP)) + rest),
    ]


def own_twin():
    camera = '[[camera]]\nname = "c{}"\nlensmodel = "LENSMODEL_PINHOLE"\nimagersize = [8, 8]\nintrinsics = [9, 9, 4, 4]\n'
    lens = 'lensmodel = "LENSMODEL_OPENCV4"'
    return deep_toml('schema = "fringetwin-twin/1"\n') + edits("twin", [
        ("image_of_2_billion", "imagersize = [160, 120]", "imagersize = [2000000000, 2000000000]"),
        ("image_beyond_int", "imagersize = [160, 120]", "imagersize = [9223372036854775807, 120]"),
        ("image_of_half_pixels", "imagersize = [160, 120]", "imagersize = [160.5, 120]"),
        ("image_of_three_sizes", "imagersize = [160, 120]", "imagersize = [160, 120, 1]"),
        ("image_of_no_width", "imagersize = [160, 120]", "imagersize = [0, 120]"),
        ("focal_length_negative", "[260, 260,", "[-260, 260,"),
        ("focal_length_infinite", "[260, 260,", "[inf, 260,"),
        ("focal_length_denormal", "[260, 260,", "[5e-324, 260,"),
        ("distortion_1e308", "-0.1, 0.1, 0, 0]", "1e308, -1e308, 1e308, 0]"),
        ("pose_of_five_numbers", "[0, 0, 0, 0, 0, 0]", "[0, 0, 0, 0, 0]"),
        ("pose_of_words", "[0, 0, 0, 0, 0, 0]", '["a", "b", "c", "d", "e", "f"]'),
        ("steps_a_billion", "steps = 4", "steps = 1000000000"),
        ("steps_two", "steps = 4", "steps = 2"),
        ("no_pitch", "[13, 14, 15]", "[]"),
        ("pitch_of_zero", "[13, 14, 15]", "[0, 14, 15]"),
        ("pitch_of_1e_300", "[13, 14, 15]", "[1e-300, 14, 15]"),
        ("pitches_without_common_period", "[13, 14, 15]", "[13, 13, 13]"),
        ("direction_z", '["x"]', '["z"]'),
        ("gain_in_quotes", "gain_dn = 20", 'gain_dn = "20"'),
        ("gain_1e999", "gain_dn = 20", "gain_dn = 1e999"),
        ("gain_a_date", "gain_dn = 20", "gain_dn = 1979-05-27T07:32:00Z"),
        ("camera_name_is_a_path", 'name = "left"', 'name = "../../left"'),
        ("camera_name_with_nul", 'name = "left"', 'name = "le\\u0000ft"'),
        ("camera_name_of_a_megabyte", 'name = "left"', f'name = "{"l" * (1 << 20)}"'),
        ("one_camera_no_list", "[[camera]]", "[camera]"),
        ("key_twice", "gain_dn = 20", "gain_dn = 20\ngain_dn = 21"),
        ("table_and_value", "[measure]", "measure = 1\n[measure]"),
        ("fit_of_no_object", '[[measure.fit]]\nobject = "part"', '[[measure.fit]]\nobject = "tarp"'),
        ("triangulate_otherwise", 'triangulate = "projector"', 'triangulate = "\\u001b[31mboth"'),
        ("radius_negative", "radius_mm = 19", "radius_mm = -19"),
        ("radius_1e300", "radius_mm = 19", "radius_mm = 1e300"),
        ("mesh_without_a_name", SPHERE, 'shape = "mesh"\nfile = ""'),
        ("mesh_is_the_folder", SPHERE, 'shape = "mesh"\nfile = "."'),
        ("mesh_is_dev_zero", SPHERE, 'shape = "mesh"\nfile = "/dev/zero"'),
        ("mesh_is_this_twin", SPHERE, 'shape = "mesh"\nfile = "twin.toml"'),
        ("mesh_in_a_variable", SPHERE, 'shape = "mesh"\nfile = "${HOME}/x"'),
        ("mesh_name_of_5000", SPHERE, f'shape = "mesh"\nfile = "{"m" * 5000}.ply"'),
        ("model_is_dev_zero", lens, 'model = "/dev/zero"'),
        ("model_is_dev_stdin", lens, 'model = "/dev/stdin"'),
        ("lens_of_no_knots", '"LENSMODEL_OPENCV4"', '"LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=0_Ny=0_fov_x_deg=44"'),
        ("lens_of_order_9", '"LENSMODEL_OPENCV4"', '"LENSMODEL_SPLINED_STEREOGRAPHIC_order=9_Nx=4_Ny=4_fov_x_deg=44"'),
        ("lens_of_field_nan", '"LENSMODEL_OPENCV4"', '"LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=4_Ny=4_fov_x_deg=nan"'),
        ("lens_name_of_a_megabyte", '"LENSMODEL_OPENCV4"', f'"LENSMODEL_{"O" * (1 << 20)}"'),
        ("text_without_end", 'name = "small"', 'name = """small'),
        ("carriage_returns_only", "\n", "\r"),
    ]) + [text("cameras_10000",
        'schema = "fringetwin-twin/1"\nname = "x"\n' + "".join(camera.format(i) for i in range(10_000)))]


def own_capture_set():
    pattern = 'pattern = "left/%04d.png"'
    numbers = ", ".join(f'"left/{i:04d}.png"' for i in range(12))
    return deep_toml('schema = "fringetwin-captures/1"\n') + edits("capture_set", [
        ("pattern_folds_away", pattern, 'pattern = "left/%04d/../0000.png"'),
        ("pattern_of_a_device", pattern, 'pattern = "/dev/../dev/zero%d"'),
        ("pattern_two_numbers", pattern, 'pattern = "left/%04d/%04d.png"'),
        ("pattern_of_text", pattern, 'pattern = "left/%s.png"'),
        ("pattern_of_a_billion_digits", pattern, 'pattern = "left/%01000000000d.png"'),
        ("pattern_writes", pattern, 'pattern = "left/%n.png"'),
        ("files_are_the_set_itself", pattern, "files = [" + ", ".join(['"capture.toml"'] * 12) + "]"),
        ("files_are_dev_zero", pattern, "files = [" + ", ".join(['"/dev/zero"'] * 12) + "]"),
        ("files_are_folders", pattern, "files = [" + ", ".join(['"left"'] * 12) + "]"),
        ("files_are_numbers", pattern, "files = [1, 2, 3]"),
        ("files_none", pattern, "files = []"),
        ("files_one_missing", pattern, f"files = [{numbers[:-8]}7.png\"]"),
        ("files_with_nul", pattern, "files = [" + numbers.replace("0003.png", "0003.png\\u0000") + "]"),
        ("files_a_million", pattern, "files = [" + '"left/0000.png",' * 1_000_000 + "]"),
        ("root_of_another", 'root = "."', 'root = "/proc/self/fd"'),
        ("root_with_nul", 'root = "."', 'root = "\\u0000"'),
        ("pattern_with_nul", pattern, 'pattern = "left/0000.png\\u0000%04d.png"'),
        ("root_in_a_variable", 'root = "."', 'root = "${HOME}"'),
        ("white_is_a_device", 'root = "."', 'root = "."\nwhite = "/dev/urandom"'),
        ("exposure_negative", 'root = "."', 'root = "."\ngray_code_exposure = -1'),
        ("camera_of_no_twin", 'name = "left"', 'name = "right"'),
        ("camera_twice", "[provenance]", '[[camera]]\nname = "left"\npattern = "left/%04d.png"\n[provenance]'),
        ("channel_of_no_colour", "[[camera]]", 'channel = "infrared"\n[[camera]]'),
        ("channel_is_a_number", "[[camera]]", "channel = 1\n[[camera]]"),
        ("schema_of_the_future", "fringetwin-captures/1", "fringetwin-captures/2"),
        ("schema_is_a_list", '"fringetwin-captures/1"', "[]"),
    ])


def own_study():
    rows = "rows = [[8, 20], [10, 80]]"
    return deep_toml('schema = "fringetwin-study/1"\n') + edits("study", [
        ("kind_unknown", "noise_seeds = 2", 'noise_seeds = 2\nkind = "\\u001b[31m"'),
        ("seeds_negative", "noise_seeds = 2", "noise_seeds = -2"),
        ("seeds_2_billion", "noise_seeds = 2", "noise_seeds = 2000000000"),
        ("no_values", "values = [18, 19, 20]", "values = []"),
        ("range_backwards", "values = [18, 19, 20]", "range = [20, 18]\ncount = 3"),
        ("range_of_a_billion", "values = [18, 19, 20]", "range = [18, 20]\ncount = 1000000000"),
        ("range_log_of_zero", "values = [18, 19, 20]", 'range = [0, 20]\ncount = 3\nscale = "log"'),
        ("range_infinite", "values = [18, 19, 20]", "range = [-1e308, 1e308]\ncount = 3"),
        ("values_are_tables", "values = [18, 19, 20]", "values = [{a = 1}, {b = 2}]"),
        ("values_break_out", "values = [18, 19, 20]", 'values = ["1\\n[camera]\\n"]'),
        ("rows_ragged", rows, "rows = [[8, 20], [10]]"),
        ("rows_no_rows", rows, "rows = 8"),
        ("key_of_nothing", "object.part.radius_mm", "object.tarp.radius_mm"),
        ("key_of_index_2_pow_64", "object.part.radius_mm", "object[18446744073709551616].radius_mm"),
        ("key_of_index_negative", "object.part.radius_mm", "object[-1].radius_mm"),
        ("key_of_100000_parts", "object.part.radius_mm", ".".join("a" * DEEP)),
        ("key_empty", "object.part.radius_mm", ""),
        ("key_twice", "camera.left.sensor.bit_depth", "object.part.radius_mm"),
        ("result_without_name", 'name = "radius_mm"', 'name = ""'),
        ("result_twice", "[[record]]", '[[record]]\nresult = "fits.part.measured.rms_mm"\nname = "radius_mm"\n[[record]]'),
        ("twin_is_dev_zero", 'twin = "twin.toml"', 'twin = "/dev/zero"'),
        ("twin_is_this_study", 'twin = "twin.toml"', 'twin = "study.toml"'),
        ("twin_missing", 'twin = "twin.toml"', 'twin = "gone.toml"'),
        ("form_of_no_sphere", "noise_seeds = 2", 'kind = "monte-carlo"\n[[uncertain]]\nform = "tarp"\nrms_mm = 1e999'),
        ("trials_beyond_int", "noise_seeds = 2", 'kind = "monte-carlo"\nmost_trials = 9223372036854775807'),
    ])


def own_cameramodel():
    intrinsics = "[ 260.0, 260.0, 79.5, 59.5, -0.1, 0.1, 0.0, 0.0,]"
    return edits("cameramodel", [
        ("sum_instead_of_number", intrinsics, "[ 130.0 + 130.0, 260, 79.5, 59.5, 0, 0, 0, 0 ]"),
        ("complex_number", intrinsics, "[ 260j, 260, 79.5, 59.5, 0, 0, 0, 0 ]"),
        ("numbers_nested", intrinsics, "[[ 260, 260, 79.5, 59.5, 0, 0, 0, 0 ]]"),
        ("numbers_call_a_function", intrinsics, "__import__('os').system('true')"),
        ("numbers_inf", intrinsics, "[ float('inf'), 260, 79.5, 59.5, 0, 0, 0, 0 ]"),
        ("numbers_1e999", intrinsics, "[ 1e999, 260, 79.5, 59.5, 0, 0, 0, 0 ]"),
        ("numbers_a_million", intrinsics, "[" + "1, " * 1_000_000 + "]"),
        ("image_of_1e18", "[ 160, 120,]", "[ 1000000000000000000, 120,]"),
        ("image_of_halves", "[ 160, 120,]", "[ 160.5, 120,]"),
        ("lens_with_quote_inside", "'LENSMODEL_OPENCV4'", "'LENSMODEL_\\'OPENCV4'"),
        ("lens_configuration_unknown", "'LENSMODEL_OPENCV4'", "'LENSMODEL_OPENCV4_order=3'"),
        ("lens_name_formatted", "'LENSMODEL_OPENCV4'", "'LENSMODEL_%s%n%n'"),
        ("lens_cahvore_without_linearity", "'LENSMODEL_OPENCV4'", "'LENSMODEL_CAHVORE'"),
        ("lens_cahvore_of_nan", "'LENSMODEL_OPENCV4'", "'LENSMODEL_CAHVORE_linearity=nan'"),
        ("lens_of_knots_that_overflow", "'LENSMODEL_OPENCV4'", "'LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=33025_Ny=65026_fov_x_deg=44'"),
        ("lens_of_65536_knots", "'LENSMODEL_OPENCV4'", "'LENSMODEL_SPLINED_STEREOGRAPHIC_order=2_Nx=65536_Ny=7_fov_x_deg=100'"),
        ("lens_of_knots_modulo_65536", "'LENSMODEL_OPENCV4'", "'LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=65540_Ny=4_fov_x_deg=44'"),
        ("lens_of_negative_field", "'LENSMODEL_OPENCV4'", "'LENSMODEL_SPLINED_STEREOGRAPHIC_order=2_Nx=4_Ny=4_fov_x_deg=-44'"),
        ("key_twice", "'imagersize'", "'lensmodel': 'LENSMODEL_PINHOLE', 'imagersize'"),
        ("text_without_end", "'LENSMODEL_OPENCV4'", "'LENSMODEL_OPENCV4"),
        ("ends_in_backslash", "0,\n}", "'\\"),
        ("two_models", "0,\n}", "0,\n}\n{}"),
        ("a_set_of_numbers", "'icam_intrinsics': 0", "1, 2"),
    ]) + [
        text("nested_100000", "{'extra': " + "[" * DEEP + "]" * DEEP + "}"),
        text("nested_dicts_100000", "{'a': " * DEEP + "0" + "}" * DEEP),
        text("keys_100000", "{" + "".join(f"'k{i}': {i},\n" for i in range(DEEP)) + "}"),
        text("comment_of_a_megabyte", "#" + "x" * (1 << 20)),
    ]


def own_opencv():
    laughs = "".join(f'<!ENTITY l{i + 1} "{f"&l{i};" * 10}">' for i in range(9))
    return edits("opencv", [
        ("rows_negative", "rows: 3", "rows: -3"),
        ("rows_a_billion", "rows: 3", "rows: 1000000000"),
        ("rows_times_columns_overflow", "rows: 3\n   cols: 3", "rows: 65536\n   cols: 65536"),
        ("rows_are_text", "rows: 3", "rows: three"),
        ("type_unknown", "dt: d", "dt: z"),
        ("type_of_900_channels", "dt: d", 'dt: "900d"'),
        ("numbers_too_few", "0., 0., 1. ]", "1. ]"),
        ("matrix_is_a_number", "M1: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d", "M1: 3\nM0: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d"),
        ("rotation_is_a_reflection", "[ 1., 0., 0., 0., 1., 0., 0., 0., 1. ]", "[ 1., 0., 0., 0., 1., 0., 0., 0., -1. ]"),
        ("rotation_is_nan", "[ 1., 0., 0., 0., 1., 0., 0., 0., 1. ]", "[ .Nan, 0., 0., 0., 1., 0., 0., 0., 1. ]"),
        ("translation_1e308", "-94.5914", "1e308"),
        ("bytes_without_end", "data: [ 1700.15", 'data: !!binary |\n   "$base64$'),
        ("tab", "   rows: 3", "\trows: 3"),
    ]) + [
        text("sequence_at_the_top", "%YAML:1.0\n---\n- 1\n- 2\n"),
        text("nested_100000", "%YAML:1.0\n---\nM1: " + "[" * DEEP + "]" * DEEP + "\n"),
        text("nested_by_indentation", "%YAML:1.0\n---\n" + "".join(" " * i + "a:\n" for i in range(3000))),
        text("nested_100000", '{"M1": ' + "[" * DEEP + "]" * DEEP + "}", ".json"),
        text("list_at_the_top", "[1, 2]", ".json"),
        text("not_closed", '{"M1": {"type_id": "opencv-matrix", "rows": 3', ".json"),
        text("bytes_of_nothing", '{"M1": "$base64$"}', ".json"),
        text("nested_100000", '<?xml version="1.0"?><opencv_storage>' + "<a>" * DEEP + "</a>" * DEEP + "</opencv_storage>", ".xml"),
        text("head_without_end", "<?xml version=", ".xml"),
        text("comment_without_end", '<?xml version="1.0"?><opencv_storage><!--', ".xml"),
        text("a_billion_laughs", f'<?xml version="1.0"?><!DOCTYPE x [<!ENTITY l0 "ha">{laughs}]><opencv_storage><M1>&l9;</M1></opencv_storage>', ".xml"),
        text("wrong_end", '<?xml version="1.0"?><opencv_storage><M1></opencv_storage></M1>', ".xml"),
    ]


def own_kalibr():
    camera = "cam{}:\n  camera_model: pinhole\n  distortion_model: none\n  intrinsics: [450, 450, 300, 200]\n  resolution: [600, 400]\n"
    return edits("kalibr", [
        ("model_unknown", "camera_model: pinhole", "camera_model: omni"),
        ("distortion_unknown", "distortion_model: radtan", "distortion_model: equidistant"),
        ("intrinsics_five", "[458.5, 457.25, 367.0, 248.5]", "[1, 458.5, 457.25, 367.0, 248.5]"),
        ("intrinsics_1e308", "[458.5, 457.25, 367.0, 248.5]", "[1e308, 1e308, 1e308, 1e308]"),
        ("intrinsics_zero", "[458.5, 457.25, 367.0, 248.5]", "[0, 0, 0, 0]"),
        ("resolution_1e308", "[752, 480]", "[1e308, 480]"),
        ("resolution_of_halves", "[752, 480]", "[752.5, 480]"),
        ("resolution_zero", "[752, 480]", "[0, 0]"),
        ("pose_1e308", "[1.0, 0.0, 0.0, -0.11]", "[1.0, 0.0, 0.0, 1e308]"),
        ("pose_is_no_rotation", "[1.0, 0.0, 0.0, -0.11]", "[1e-308, 0.0, 0.0, -0.11]"),
        ("pose_of_three_rows", "  - [0.0, 0.0, 0.0, 1.0]\n", ""),
        ("pose_last_row", "[0.0, 0.0, 0.0, 1.0]", "[0.0, 0.0, 1.0, 0.0]"),
        ("key_twice", "  resolution: [752, 480]", "  resolution: [752, 480]\n  resolution: [752, 480]"),
        ("second_camera_without_pose", "  T_cn_cnm1:\n", "  T_other:\n"),
    ]) + [
        text("cameras_10000", "".join(camera.format(i) for i in range(10_000))),
        text("keys_200000", lambda: "cam0:\n" + "".join(f"  k{i}: {i}\n" for i in range(200_000))),
        text("blocks_without_keys", lambda: "".join(f"c{i}:\n" for i in range(200_000))),
        text("value_of_a_megabyte", "cam0:\n  camera_model: " + "p" * (1 << 20) + "\n"),
    ]


def own_matrices():
    return [
        text("K_two_by_two", "1 0\n0 1\n"), text("K_ragged", "1700 0 600\n0 1700\n0 0 1\n"),
        text("K_transposed", "1700 0 0\n0 1700 0\n600 400 1\n"),
        text("K_1e999", "1e999 0 600\n0 1700 400\n0 0 1\n"), text("K_1e308", "1e308 0 1e308\n0 1e308 1e308\n0 0 1\n"),
        text("K_hexadecimal", "0x6A4 0 600\n0 1700 400\n0 0 1\n"), text("K_only_comments", "# 1 2 3\n# 4 5 6\n"),
        text("K_a_million_numbers", lambda: "1 " * 1_000_000 + "\n"), text("K_a_million_lines", lambda: "1\n" * 1_000_000),
        text("K_word_of_a_megabyte", "x" * (1 << 20)), text("D_six", "0 0 0 0 0 0\n"),
        text("D_with_tilt", "0 " * 12 + "0.1 0.1\n"),
        text("D_square", "0 0\n0 0\n"), text("D_1e308", "1e308 1e308 1e308 1e308\n"),
        text("R_reflection", "1 0 0\n0 1 0\n0 0 -1\n"),
        text("R_1e308", "1e308 0 0\n0 1e308 0\n0 0 1e308\n"), text("R_vector_1e308", "1e308 0 0\n"),
        text("R_four_numbers", "1 0 0 0\n"),
        text("T_four", "1 2 3 4\n"), text("T_a_word", "1 2 three\n"),
    ]


def own_corners():
    head = "# filename x y level\n"
    whole = good_text("corners")
    first = whole.splitlines()[1]  # of left0.png
    return [
        text("head_alone", head), text("two_columns", head + "left0.png 1\n"),
        text("coordinate_is_a_word", whole.replace(first, "left0.png one 2 0")),
        text("coordinate_nan", whole.replace(first, "left0.png nan 2 0")),
        text("coordinate_1e999", whole.replace(first, "left0.png 1e999 2 0")),
        text("coordinate_1e308", whole.replace(first, "left0.png 1e308 -1e308 0")),
        text("level_1e308", whole.replace(" 0\n", " 1e308\n")), text("level_minus_1e308", whole.replace(" 0\n", " -1e308\n")),
        text("corners_15_of_16", whole.replace(first + "\n", "")), text("image_again_later", whole + first + "\n"),
        text("all_corners_in_one_place", "".join(f"{line.split()[0]} 5 5 0\n" for line in whole.splitlines()[1:-1])),
        text("one_device_only", "".join(line for line in whole.splitlines(True) if not line.startswith("right"))),
        text("image_name_of_a_megabyte", head + "left" + "0" * (1 << 20) + ".png 1 2\n"),
        text("image_number_of_5000_digits", whole.replace("right", "x").replace("left0.png", f"left{'9' * 5000}.png")),
        text("image_name_with_escape_sequence", whole.replace("right", "x").replace("left0", "left\x1b[31m")),
        text("images_200000_the_last_wrong", lambda: head + "".join(f"left{i}.png - - -\n" for i in range(200_000)) + "left 1\n"),
        text("images_200000_without_a_board", lambda: head + "".join(f"left{i}.png - - -\n" for i in range(200_000))),
    ]


def own_meshes():
    head = "ply\nformat ascii 1.0\n"
    vertices = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    face = "element face 1\nproperty list uchar int vertex_indices\n"
    three, one = "0 0 270\n1 0 270\n0 1 270\n", "3 0 1 2\n"
    ply = {
        "no_end_of_header": head + vertices,
        "elements_100000": head + "element x 1\n" * DEEP + vertices + face + "end_header\n" + three + "3 0 1 9\n",
        "properties_100000": head + "element vertex 3\n" + "property float x\n" * DEEP + "end_header\n",
        "face_of_2_corners_only": head + vertices + face + "end_header\n" + three + "2 0 1\n",
        "index_of_one_and_a_half": head + vertices + face + "end_header\n" + three + "3 0 1 1.5\n",
        "index_nan": head + vertices + face + "end_header\n" + three + "3 0 1 nan\n",
        "corner_count_of_a_float": head + vertices + face.replace("uchar", "float") + "end_header\n" + three + "3.5 0 1 2\n",
        "corner_count_inf": head + vertices + face.replace("uchar", "double") + "end_header\n" + three + "inf 0 1 2\n",
        "vertices_9e18_binary": head.replace("ascii", "binary_little_endian") + vertices.replace("3", "9000000000000000000") + face + "end_header\n",
        "vertices_3_billion": head + vertices.replace("3", "3000000000") + face + "end_header\n" + three + one,
        "no_faces": head + vertices + "end_header\n" + three,
        "faces_without_area": head + vertices + face + "end_header\n" + "0 0 270\n" * 3 + one,
        "header_line_of_a_megabyte": head + "comment" + "y" * (1 << 20) + "\nnonsense" + "x" * (1 << 20) + "\n",
        "format_with_escape_sequence": "ply\nformat \x1b[31m 1.0\nend_header\n",
        "magic_alone": "ply\n",
    }
    obj = {
        "only_a_material": "mtllib part.obj\n", "material_is_a_device": "mtllib /dev/zero\n",
        "face_of_words": "v 0 0 0\nv 1 0 0\nv 0 1 0\nf a b c\n",
        "face_beyond": "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "face_below": "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -4\n",
        "face_beyond_int": "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999\n",
        "vertex_1e999": "v 1e999 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "vertex_of_words": "v x y z\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "vertex_beyond_1e9": "v 1e30 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "vertices_alone": "v 0 0 0\n" * 1000, "line_goes_on_for_ever": "v 0 0 \\\n" * 10000,
                "polygon_without_vertices": "f " + "1 " * DEEP + "\n",
        "object_name_of_a_megabyte": "o " + "x" * (1 << 20) + "\nf 1 2 3\n",
    }
    facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 270\nvertex 1 0 270\nvertex 0 1 270\nendloop\nendfacet\n"
    stl = {
        "head_alone": "solid x\n", "nothing_inside": "solid x\nendsolid x\n",
        "corner_of_two_numbers": "solid x\n" + facet.replace("1 0 270", "1 0") + "endsolid x\n",
        "corner_1e999": "solid x\n" + facet.replace("1 0 270", "1e999 0 0") + "endsolid x\n",
        "corners_two": "solid x\n" + facet.replace("vertex 1 0 270\n", "") + "endsolid x\n",
        "words": "solid x\n" + "vertex " * 1000 + "endsolid x\n",
        "binary_of_4_billion": b"\0" * 80 + b"\xff" * 4 + b"\0" * 50, "binary_of_none": b"\0" * 84,
        "binary_of_nan": b"\0" * 80 + b"\1\0\0\0" + b"\xff" * 50, "name_of_a_megabyte": "solid " + "x" * (1 << 20),
    }
    return {"ply": ply, "obj": obj, "stl": stl}


def own_large_meshes():
    """What is wrong with these shows in their first bytes; read whole they would take 4 GiB. And much work in few bytes."""
    vertices = b"element vertex 3\nproperty float x\nproperty float y\n"
    return {
        "ply": [Bad("4_GiB_of_an_unknown_format", begins(b"ply\nformat asci 1.0\n")),
                Bad("4_GiB_without_z", begins(b"ply\nformat ascii 1.0\n" + vertices + b"end_header\n")),
                Bad("4_GiB_without_an_end_of_header", begins(b"ply\nformat ascii 1.0\n" + vertices))],
        "stl": [Bad("4_GiB_binary_of_3_facets", begins(bytes(80) + b"\3\0\0\0")), Bad("4_GiB_ascii_without_a_facet", begins(b"solid x\n"))],
        "obj": [Bad("4_GiB_of_zeros_behind_a_vertex", begins(b"v 0 0 0\n")), text("spirals_of_1990_corners", lambda: spirals(100, 1990))],
    }


OWN = {"twin": own_twin, "capture_set": own_capture_set, "study": own_study, "cameramodel": own_cameramodel,
       "opencv": own_opencv, "kalibr": own_kalibr, "matrices": own_matrices, "corners": own_corners}


def own(reader):
    """The cases of one reader."""
    if reader in OWN:
        return OWN[reader]()
    return [text(name, content) for name, content in own_meshes().get(reader, {}).items()] + own_large_meshes().get(reader, [])
