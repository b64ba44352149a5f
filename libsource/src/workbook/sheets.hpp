// SPDX-License-Identifier: MIT
// The sheets of workbooks of Excel (Office Open XML, ECMA-376) and OpenDocument (ODF 1.3).
#pragma once

#include <string>
#include <vector>

#include "workbook/archive.hpp"
#include "workbook/sheet_text.hpp"

namespace silvafit::source {

struct Sheet {
  std::string name{};
  bool is_hidden = false;
  SheetText text;
};

/// Reads all sheets in their order, or only the one with a name. Formulas have their stored values.
/// \param wanted  empty for all
/// \param budget  of the workbook; must outlive the sheets
/// \throws InputError if a part that belongs to the workbook is missing or damaged, or has content
///   that its format does not allow
std::vector<Sheet> sheets_of_excel(Archive& archive,
                                   const std::string& wanted,
                                   SheetBudget& budget);
std::vector<Sheet> sheets_of_open_document(Archive& archive,
                                           const std::string& wanted,
                                           SheetBudget& budget);

/// The place of a sheet for messages: "trees.xlsx (sheet Trees)".
std::string place_of_sheet(const std::string& file, const std::string& sheet);

}  // namespace silvafit::source
