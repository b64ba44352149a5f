// SPDX-License-Identifier: MIT
#include "gdal/stored_types.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <vector>

namespace silvafit::source {
namespace {

/// Whether each expression holds for a row, or all are 0 if the query fails, as reading then does.
std::vector<int> any_of(sqlite3& database,
                        const std::string& rows,
                        const std::vector<std::string>& expressions) {
  std::string sql;
  for (const std::string& expression : expressions) {
    sql += fmt::format("{}max({})", sql.empty() ? "select " : ", ", expression);
  }
  sql += " from " + rows;
  std::vector<int> results(expressions.size(), 0);
  sqlite3_stmt* statement = nullptr;
  sqlite3_prepare_v2(&database, sql.c_str(), -1, &statement, nullptr);
  if (statement != nullptr && sqlite3_step(statement) == SQLITE_ROW) {
    for (std::size_t i = 0; i < results.size(); ++i) {
      results[i] = sqlite3_column_int(statement, static_cast<int>(i));
    }
  }
  sqlite3_finalize(statement);
  return results;
}

bool is_boolean(const OGRFieldDefn& field) { return field.GetSubType() == OFSTBoolean; }

bool is_whole(const OGRFieldDefn& field) {
  return field.GetType() == OFTInteger || field.GetType() == OFTInteger64;
}

}  // namespace

std::string quoted_name(const std::string& name) {
  std::string text = "\"";
  for (const char c : name) text += c == '"' ? std::string("\"\"") : std::string(1, c);
  return text + '"';
}

void take_stored_types(sqlite3& database, const std::string& rows, OGRLayer& layer) {
  OGRFeatureDefn& definition = *layer.GetLayerDefn();
  std::vector<OGRFieldDefn*> fields;
  for (int i = 0; i < definition.GetFieldCount(); ++i) {
    OGRFieldDefn* const field = definition.GetFieldDefn(i);
    const bool is_text = field->GetType() == OFTString || field->GetType() == OFTBinary;
    if (!is_text) fields.push_back(field);
  }
  constexpr std::size_t kKinds = 3;
  // SQLite allows 2,000 columns of a result.
  constexpr std::size_t kMostFields = 600;
  for (std::size_t begin = 0; begin < fields.size(); begin += kMostFields) {
    const std::size_t end = std::min(begin + kMostFields, fields.size());
    std::vector<std::string> questions;
    for (std::size_t i = begin; i < end; ++i) {
      const std::string name = quoted_name(fields[i]->GetNameRef());
      questions.push_back(fmt::format("typeof({}) in ('text', 'blob')", name));
      questions.push_back(fmt::format("typeof({}) = 'real'", name));
      questions.push_back(fmt::format("{} not in (0, 1)", name));
    }
    const std::vector<int> answers = any_of(database, rows, questions);
    for (std::size_t i = begin; i < end; ++i) {
      OGRFieldDefn& field = *fields[i];
      const std::size_t first = kKinds * (i - begin);
      const bool has_texts = answers[first] != 0;
      const bool has_reals = answers[first + 1] != 0;
      if (is_boolean(field) && !has_texts && answers[first + 2] == 0) continue;
      if (!has_texts && !is_whole(field)) continue;
      field.SetSubType(OFSTNone);
      field.SetType(has_texts ? OFTString : has_reals ? OFTReal : OFTInteger64);
    }
  }
}

}  // namespace silvafit::source
