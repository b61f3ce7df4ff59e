# SPDX-License-Identifier: Apache-2.0
"""Bad files of the kinds that the program writes itself and reads again: results, calibrations, journals of captures and
shares of studies. The others: bad_files_made.py, bad_files_binary.py."""
from bad_files_made import DEEP, edits, text


def own_result_json():
    return edits("result_json", [
        ("fits_a_number", '"fits": [', '"fits": 5, "other": ['), ("fits_of_numbers", '"fits": [', '"fits": [1, "a", null, '),
        ("gain_a_text", '"gain": [', '"gain": "x", "other": ['),
        ("gain_of_lists", '"gain": [', '"gain": [[], [[]], '),
        ("camera_a_list_of_numbers", '"camera": "left", "gain', '"camera": [1, 2], "gain'),
        ("number_1e999", "17.3", "1e999"),
        ("verdict_a_table", '"verdict": "pass"', '"verdict": {"a": []}'),
        ("object_a_number", '"object": "part"', '"object": 7'),
        ("schema_a_list", '"fringetwin-result/1"', '["fringetwin-result/1"]'), ("half_a_surrogate", '"part"', '"\\ud800"'),
    ]) + [
        text("nested_100000", '{"schema": "fringetwin-result/1", "fits": ' + "[" * DEEP + "]" * DEEP + "}"),
        text("tables_100000", '{"a":' * DEEP + "1" + "}" * DEEP), text("a_number", "1"), text("null", "null"),
        text("two_results", "{}{}"),
        text("numbers_100000", '{"schema": "fringetwin-result/1", "fits": [{"object": "part", "measured": {' +
             ", ".join(f'"n{i}": {i}' for i in range(DEEP)) + "}}]}", may_pass=True),
    ]


def own_calibration_json():
    return edits("calibration_json", [
        ("variance_1e999", "4e-4", "1e999"), ("variance_negative", "4e-4", "-4e-4"), ("variance_text", "4e-4", '"4e-4"'),
        ("variances_1e308", "4e-4", "1e308"),
        ("parameters_a_number", '["left.fx", "left.k1", "projector.t3"]', "3"),
        ("parameters_numbers", '["left.fx", "left.k1", "projector.t3"]', "[1, 2, 3]"),
        ("parameters_tables", '["left.fx", "left.k1", "projector.t3"]', "[{}, {}, {}]"),
        ("parameter_of_dots", '"left.fx"', '"...."'), ("parameter_empty", '"left.fx"', '""'),
        ("devices_a_table", '[{"name": "left"}]', "{}"),
        ("device_name_a_number", '"name": "left"', '"name": 3'),
        ("covariance_a_list", '"covariance": {', '"covariance": [], "other": {'),
        ("matrix_ragged", "[0, 0, 1e-4]", "[0, 1e-4]"), ("schema_a_number", '"fringetwin-calibration/1"', "1"),
    ]) + [
        text("nested_100000", '{"schema": "fringetwin-calibration/1", "devices": ' + "[" * DEEP + "]" * DEEP + "}"),
        text("nested_beside_what_is_right", '{"schema": "fringetwin-calibration/1", "covariance": {"parameters": ["left.fx"], "matrix": [[1]]}, "devices": '
             + "[" * 10 * DEEP + "]" * 10 * DEEP + "}"),
        text("parameters_5000",
        '{"schema": "fringetwin-calibration/1", "devices": [{"name": "left"}], "covariance": {"parameters": [' +
             ", ".join(['"left.fx"'] * 5000) + '], "matrix": []}}'),
        text("parameters_none", '{"schema": "fringetwin-calibration/1", "devices": [{"name": "left"}], "covariance": {"parameters": [], "matrix": []}}'),
    ]


def journal_line(step="0", at="1", lost="0"):
    """A finished step as the program writes it, but for the numbers given."""
    return (f'{{"attempts":1,"corrupt":0,"frames":[],"lost":{lost},"pattern":"p","repeated":0,"sha256":{{}},"shown":[{at},1,true],'
            f'"skew_ms":0.0,"step":{step}}}\n')


def own_journal():
    head = '{"identity":{},"schema":"fringetwin-capture-journal/1"}\n'
    return [text("not_json", "journal\n"), text("a_list", "[]\n"),
        text("identity_of_numbers", head.replace("{}", '{"a":1}')), text("identity_a_list", head.replace("{}", "[]")),
            text("schema_missing", '{"identity":{}}\n'), text("line_of_nothing", head + "\n\n"),
            text("step_1e999", head + '{"step":1e999}\n'),
            text("step_35e37", head + journal_line(step="3.5e+38")), text("step_of_a_half", head + journal_line(step="0.5")),
            text("lost_1e38", head + journal_line(lost="1e38")), text("shown_at_18446744073709551615", head + journal_line(at="18446744073709551615")),
            text("nested_100000", head + "[" * DEEP + "\n")]


SHARD_TASK = '{"twin":"twin.toml","device":"","records":[],"virtual_rig":false,"calibration":false}\n'


def shard_point(id="0", seed="0", group="0"):
    """A point of a share as the program writes it, but for the numbers given."""
    return (f'{{"id":{id},"settings":{{}},"seed":{seed},"group":{group},"trace":"t","form":"f","sensors":[[8,100]],"mean":0.5,'
            '"amplitude":0.5}\n')


def own_shard():
    return [text("not_json", "shard\n"), text("task_a_list", "[]\n"), text("task_empty", "{}\n"),
        text("nested_100000", "[" * DEEP + "\n"), text("task_a_number", "1e999\n"),
        text("id_1e38", SHARD_TASK + shard_point(id="1e38")), text("id_of_a_half", SHARD_TASK + shard_point(id="0.5")),
        text("seed_below_0", SHARD_TASK + shard_point(seed="-1")), text("seed_1e19", SHARD_TASK + shard_point(seed="1e19")),
        text("group_1e308", SHARD_TASK + shard_point(group="1e308"))]


OWN = {"result_json": own_result_json, "calibration_json": own_calibration_json, "journal": own_journal, "shard": own_shard}


def own(reader):
    """The cases of one reader."""
    return OWN[reader]() if reader in OWN else []
