// SPDX-License-Identifier: Apache-2.0
#include "compare/result/result_schema.hpp"

#include "compare/result/tables.hpp"

namespace fringetwin::compare {
namespace {

using report::Json;

constexpr std::size_t kLine = 110;  ///< characters: what fits is printed on one line

/// What stands before the tables: where a result comes from, and the fits, whose numbers stand in maps.
constexpr const char* kHead = R"({
 "schema": {"const": "fringetwin-result/1"},
 "kind": {"enum": ["comparison", "measurement"]},
 "twin": {"type": "string"},
 "provenance": {
  "type": "object",
  "required": ["argv", "version", "inputs_sha256", "device", "seed"],
  "additionalProperties": false,
  "properties": {
   "argv": {"type": "array", "items": {"type": "string"}},
   "version": {"type": "string"},
   "inputs_sha256": {
    "type": "object",
    "additionalProperties": {"type": "string", "minLength": 64, "maxLength": 64}
   },
   "device": {"type": ["string", "null"]},
   "seed": {"type": "integer", "minimum": 0},
   "rendered": {
    "type": "array",
    "items": {
     "type": "object",
     "required": ["camera", "sampler", "precision", "rays_per_pixel"],
     "additionalProperties": false,
     "properties": {
      "camera": {"type": "string"},
      "sampler": {"enum": ["adaptive", "gauss", "multi-jittered", "sobol"]},
      "samples": {"type": "integer", "minimum": 1},
      "precision": {"enum": ["fp32", "fp64"]},
      "rays_per_pixel": {"type": "number", "minimum": 0},
      "estimated_phase_error_rad": {"type": "number", "minimum": 0},
      "estimated_gray_error": {"type": "number", "minimum": 0},
      "estimated_gray_error_inside": {"type": "number", "minimum": 0}
     }
    }
   }
  }
 },
 "timing_s": {"type": "object", "additionalProperties": {"type": "number", "minimum": 0}},
 "fits": {"type": "array", "items": {"$ref": "#/$defs/fit_row"}}
})";

constexpr const char* kDefinitions = R"({
 "number": {"type": ["number", "null"]},
 "positive": {"type": ["number", "null"], "minimum": 0},
 "count": {"type": "integer", "minimum": 0},
 "vector": {"type": "array", "minItems": 3, "maxItems": 3, "items": {"$ref": "#/$defs/number"}},
 "value": {"anyOf": [{"$ref": "#/$defs/number"}, {"$ref": "#/$defs/vector"}]},
 "values": {"type": ["object", "null"], "additionalProperties": {"$ref": "#/$defs/value"}},
 "fit": {
  "type": ["object", "null"],
  "required": ["rms_mm", "n"],
  "properties": {
   "n": {"$ref": "#/$defs/count"},
   "warning": {"type": "string"},
   "rms_mm": {"$ref": "#/$defs/positive"},
   "rms_all_mm": {"$ref": "#/$defs/positive"},
   "n_gated": {"$ref": "#/$defs/count"}
  },
  "additionalProperties": {"$ref": "#/$defs/value"}
 },
 "fit_row": {
  "type": "object",
  "required": ["object", "kind"],
  "additionalProperties": false,
  "properties": {
   "object": {"type": "string"},
   "kind": {"type": "string"},
   "alignment": {"type": "string"},
   "simulated": {"$ref": "#/$defs/fit"},
   "real": {"$ref": "#/$defs/fit"},
   "measured": {"$ref": "#/$defs/fit"},
   "difference": {"$ref": "#/$defs/values"},
   "z": {"$ref": "#/$defs/values"},
   "method_bias": {"$ref": "#/$defs/values"},
   "real_estimated": {"$ref": "#/$defs/values"},
   "z_estimated": {"$ref": "#/$defs/values"}
  }
 }
})";

Json reference(const char* definition) { return {{"$ref", std::string("#/$defs/") + definition}}; }

Json list_of(Json items, const Field& field) {
  Json out = {{"type", "array"}};
  if (field.fewest > 0) out["minItems"] = field.fewest;
  if (field.most > 0) out["maxItems"] = field.most;
  out["items"] = std::move(items);
  return out;
}

Json text_schema(const Field& field) {
  if (field.choices.empty()) return {{"type", field.empty_is_null ? Json{"string", "null"} : Json("string")}};
  Json choices = field.choices;
  if (field.empty_is_null) choices.push_back(nullptr);
  return {{"enum", choices}};
}

Json row_schema(const std::vector<Field>& all);

Json value_schema(const Field& field) {
  switch (field.kind) {
    case Kind::text:
      return text_schema(field);
    case Kind::texts:
      return list_of({{"type", "string"}}, field);
    case Kind::number:
      return field.always_known ? Json{{"type", "number"}} : reference("number");
    case Kind::positive:
      return reference("positive");
    case Kind::count:
      return reference("count");
    case Kind::flag:
      return {{"type", "boolean"}};
    case Kind::vector:
      return reference("vector");
    case Kind::numbers:
      return list_of(reference("number"), field);
    case Kind::matrix:
      return list_of({{"type", "array"}, {"items", reference("number")}}, field);
    case Kind::rows:
      return list_of(row_schema(field.rows()), field);
  }
  return {};
}

Json row_schema(const std::vector<Field>& all) {
  Json required = Json::array(), properties = Json::object();
  for (const Field& field : all) {
    if (field.required) required.push_back(field.key);
    properties[field.key] = value_schema(field);
    properties[field.key]["description"] =
        field.meaning + (field.unit.empty() ? "" : " [" + field.unit + "]");
  }
  return {{"type", "object"},
          {"required", required},
          {"additionalProperties", false},
          {"properties", properties}};
}

/// Writes JSON indented, but what fits on one line stays there.
std::string text_of(const Json& json, std::size_t indent) {
  const std::string line = json.dump();
  if (!json.is_structured() || indent + line.size() <= kLine) return line;
  const bool object = json.is_object();
  std::string out(1, object ? '{' : '['), separator = "\n";
  for (const auto& item : json.items()) {
    out += separator + std::string(indent + 1, ' ');
    if (object) out += Json(item.key()).dump() + ": ";
    out += text_of(item.value(), indent + 1);
    separator = ",\n";
  }
  return out + "\n" + std::string(indent, ' ') + (object ? '}' : ']');
}

}  // namespace

std::string result_schema() {
  Json properties = Json::parse(kHead);
  for (const Table& table : tables()) {
    const Json row = row_schema(table.fields());
    properties[table.key] = table.is_list ? Json{{"type", "array"}, {"items", row}} : row;
  }
  properties["verdict"] = {{"enum", {"pass", "fail", "not judged"}}};
  properties["warnings"] = {{"type", "array"}, {"items", {{"type", "string"}}}};
  const Json schema = {
      {"$schema", "https://json-schema.org/draft/2020-12/schema"},
      {"title", "fringetwin-result/1"},
      {"description",
       "result.json of fringetwin cosim, compare and measure. Units are in the key names; null = unknown. "
       "Differences are simulated - real."},
      {"type", "object"},
      {"required",
       {"schema", "provenance", "timing_s", "fits", "gain", "gray", "phase", "limits", "verdict"}},
      {"properties", properties},
      {"additionalProperties", false},
      {"$defs", Json::parse(kDefinitions)}};
  return text_of(schema, 0) + "\n";
}

}  // namespace fringetwin::compare
