// SPDX-License-Identifier: MIT
#include "study/formatted_table.hpp"

#include <catch2/catch.hpp>
#include <limits>

using namespace silvafit::study;

namespace {

FormattedTable example() {
  return {
      .name = "fits",
      .caption = "Fits & more",
      .columns = {{"model", "Model"},
                  {"aic", "AIC", ColumnKind::kCriterion},
                  {"p", "p", ColumnKind::kP},
                  {"gain", "Gain (%)", ColumnKind::kPercent}},
      .rows = {
          {std::string("a*dbh^b, \"x\""), 1234.5678, 0.00012, 10.449},
          {std::string("M_1|2"), std::numeric_limits<double>::quiet_NaN(), 0.0456, TableCell()}}};
}

}  // namespace

TEST_CASE("CSV has all digits, and quotes where they are needed") {
  CHECK(to_csv(example()) ==
        "model,aic,p,gain\n"
        "\"a*dbh^b, \"\"x\"\"\",1234.5678,0.00012,10.449\n"
        "M_1|2,,0.0456,\n");
}

TEST_CASE("Markdown has rounded numbers to the right, and no cell breaks the table") {
  CHECK(to_markdown(example()) ==
        "## Fits & more\n\n"
        "| Model | AIC | p | Gain (%) |\n"
        "|---|---:|---:|---:|\n"
        "| a\\*dbh^b, \"x\" | 1234.57 | \\< 0.001 | 10.4 |\n"
        "| M\\_1\\|2 |  | 0.046 |  |\n");
}

TEST_CASE("LaTeX has its special characters escaped") {
  CHECK(to_latex(example()) ==
        "\\begin{table}\n\\caption{Fits \\& more}\n\\label{tab:fits}\n"
        "\\begin{tabular}{lrrr}\n\\hline\n"
        "Model & AIC & p & Gain (\\%) \\\\\n\\hline\n"
        "a*dbh\\textasciicircum{}b, \"x\" & 1234.57 & \\textless{} 0.001 & 10.4 \\\\\n"
        "M\\_1|2 &  & 0.046 &  \\\\\n"
        "\\hline\n\\end{tabular}\n\\end{table}\n");
}
