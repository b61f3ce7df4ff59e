// SPDX-License-Identifier: Apache-2.0
// Makes a plain table of the page: one line per row of a table of the result, one column per field that has
// one.
#pragma once
#include <vector>

#include "compare/result/fields.hpp"
#include "report/table.hpp"

namespace fringetwin::compare {

/// Returns the table of these rows (addresses of rows that have these fields), without a caption.
report::Table field_table(const std::vector<Field>& all, const std::vector<const void*>& rows);

template <class Row>
report::Table field_table(const std::vector<Row>& rows) {
  return field_table(fields<Row>(), row_addresses(rows));
}

}  // namespace fringetwin::compare
