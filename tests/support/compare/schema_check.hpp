// SPDX-License-Identifier: Apache-2.0
// A small JSON Schema checker for the tests: the keywords docs/result.schema.json uses, and a refusal of
// any other, so that no rule is silently skipped.
#pragma once
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace fringetwin::testing {

using Json = nlohmann::json;

inline bool has_type(const Json& value, const std::string& type) {
  if (type == "object") return value.is_object();
  if (type == "array") return value.is_array();
  if (type == "string") return value.is_string();
  if (type == "integer") return value.is_number_integer();
  if (type == "number") return value.is_number();
  if (type == "boolean") return value.is_boolean();
  if (type == "null") return value.is_null();
  throw std::invalid_argument("unknown type " + type);
}

class SchemaChecker {
 public:
  explicit SchemaChecker(Json schema) : root_(std::move(schema)) {}

  /// One line per violation, with the path of the value.
  std::vector<std::string> check(const Json& value) const {
    std::vector<std::string> errors;
    check(value, root_, "$", errors);
    return errors;
  }

 private:
  void check(const Json& value, const Json& rule, const std::string& at,
             std::vector<std::string>& errors) const {
    refuse_unknown_keywords(rule);
    const auto fail = [&](const std::string& what) {
      errors.push_back(at + ": " + what + ", is " + value.dump());
    };
    if (rule.contains("$ref")) {
      const std::string ref = rule["$ref"];
      check(value, root_.at(Json::json_pointer(ref.substr(1))), at, errors);
    }
    if (rule.contains("type")) {
      const Json types = rule["type"].is_array() ? rule["type"] : Json::array({rule["type"]});
      bool any = false;
      for (const Json& type : types) any = any || has_type(value, type);
      if (!any) return fail("must be " + rule["type"].dump());
    }
    if (rule.contains("const") && value != rule["const"]) fail("must be " + rule["const"].dump());
    if (rule.contains("enum") &&
        std::find(rule["enum"].begin(), rule["enum"].end(), value) == rule["enum"].end())
      fail("must be one of " + rule["enum"].dump());
    if (rule.contains("minimum") && value.is_number() && value < rule["minimum"]) fail("too small");
    if (value.is_string()) {
      const auto length = value.get<std::string>().size();
      if (length < rule.value("minLength", 0u) || length > rule.value("maxLength", 1u << 30))
        fail("wrong length");
    }
    if (rule.contains("anyOf")) {
      bool any = false;
      for (const Json& option : rule["anyOf"]) {
        std::vector<std::string> ignored;
        check(value, option, at, ignored);
        any = any || ignored.empty();
      }
      if (!any) fail("matches no alternative");
    }
    if (value.is_array()) check_array(value, rule, at, errors);
    if (value.is_object()) check_object(value, rule, at, errors);
  }

  void check_array(const Json& value, const Json& rule, const std::string& at,
                   std::vector<std::string>& errors) const {
    if (value.size() < rule.value("minItems", 0u) || value.size() > rule.value("maxItems", 1u << 30))
      errors.push_back(at + ": wrong number of items");
    if (rule.contains("items"))
      for (std::size_t i = 0; i < value.size(); ++i)
        check(value[i], rule["items"], at + "[" + std::to_string(i) + "]", errors);
  }

  void check_object(const Json& value, const Json& rule, const std::string& at,
                    std::vector<std::string>& errors) const {
    if (rule.contains("required"))
      for (const std::string key : rule["required"])
        if (!value.contains(key)) errors.push_back(at + ": \"" + key + "\" is missing");
    const Json properties = rule.value("properties", Json::object());
    for (const auto& [key, item] : value.items()) {
      if (properties.contains(key))
        check(item, properties[key], at + "." + key, errors);
      else if (rule.contains("additionalProperties")) {
        const Json& other = rule["additionalProperties"];
        if (other == false)
          errors.push_back(at + ": \"" + key + "\" is not in the schema");
        else
          check(item, other, at + "." + key, errors);
      }
    }
  }

  static void refuse_unknown_keywords(const Json& rule) {
    static const std::set<std::string> known{
        "$schema",  "title",    "description", "$defs",     "$ref",       "type",
        "const",    "enum",     "minimum",     "minLength", "maxLength",  "anyOf",
        "minItems", "maxItems", "items",       "required",  "properties", "additionalProperties"};
    for (const auto& [key, item] : rule.items())
      if (!known.contains(key)) throw std::invalid_argument("keyword not supported: " + key);
  }

  Json root_;
};

}  // namespace fringetwin::testing
