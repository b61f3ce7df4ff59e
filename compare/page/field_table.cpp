// SPDX-License-Identifier: Apache-2.0
#include "compare/page/field_table.hpp"

#include <algorithm>

#include "report/text.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::compare {
namespace {

using Style = Column::Style;

double number_of(const Field* field, const void* row) {
  const report::Json value = field ? field->json(row) : report::Json(nullptr);
  return value.is_number() ? value.get<double>() : kNaN;
}

std::string plain_text(const Field& field, const void* row) {
  const report::Json value = field.json(row);
  if (field.kind == Kind::text) return value.get<std::string>();
  if (field.kind == Kind::count) return report::count(value.get<unsigned long long>());
  return report::number(number_of(&field, row));
}

std::string cell(const std::vector<Field>& all, const Field& field, const void* row) {
  const Column& column = *field.column;
  const double value = column.factor * number_of(&field, row);
  switch (column.style) {
    case Style::plain:
      return plain_text(field, row);
    case Style::fixed:
      return report::fixed(value, column.digits);
    case Style::signed_fixed:
      return report::signed_fixed(value, column.digits);
    case Style::significant:
      return report::number(value, column.digits);
    case Style::with_sigma:
      return report::with_sigma(
          value, number_of(find_field(all, column.sigma.empty() ? field.sigma : column.sigma), row));
  }
  return "";
}

}  // namespace

report::Table field_table(const std::vector<Field>& all, const std::vector<const void*>& rows) {
  std::vector<const Field*> shown;
  for (const Field& field : all)
    if (field.column) shown.push_back(&field);
  std::ranges::stable_sort(
      shown, [](const Field* a, const Field* b) { return a->column->place < b->column->place; });
  report::Table table;
  for (const Field* field : shown)
    table.columns.push_back({field->column->header, field->column->unit,
                             field->kind == Kind::text ? report::Align::left : report::Align::right});
  for (const void* row : rows) {
    std::vector<std::string> cells;
    for (const Field* field : shown) cells.push_back(cell(all, *field, row));
    table.add_row(std::move(cells));
  }
  return table;
}

}  // namespace fringetwin::compare
