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

TEST_CASE("Markdown has rounded numbers aligned to the right, and cells are escaped") {
  CHECK(to_markdown(example()) ==
        "## Fits & more\n\n"
        "| Model | AIC | p | Gain (%) |\n"
        "|---|---:|---:|---:|\n"
        "| a\\*dbh^b, \"x\" | 1234.57 | \\< 0.001 | 10.4 |\n"
        "| M\\_1\\|2 |  | 0.046 |  |\n");
}

TEST_CASE("LaTeX has its special characters escaped") {
  CHECK(to_latex(example()) ==
        "\\begin{table}\n\\caption{Fits \\& more}\n\\label{tab:fits}\n\\par\\smallskip\n"
        "\\begin{tabular}{lrrr}\n\\hline\n"
        "\\rule{0pt}{2.5ex}Model & AIC & p & Gain (\\%) \\\\\n\\hline\n"
        "\\rule{0pt}{2.5ex}a{*}dbh\\textasciicircum{}b, \"x\" & 1234.57 & \\textless{} 0.001 & "
        "10.4 \\\\\n"
        "M\\_1|2 &  & 0.046 &  \\\\\n"
        "\\hline\n\\end{tabular}\n\\end{table}\n");
}

TEST_CASE("negative numbers have one minus sign, and marks are beside their number") {
  const FormattedTable table{
      .name = "marks",
      .caption = "Marks",
      .columns = {{"b", "b", ColumnKind::kEstimate}, {"psi2", "\u03C8\u00B2"}},
      .rows = {{MarkedNumber{"b: ", -0.0045, "***"}, std::string("[1]")},
               {-7.51e-5, std::string("*")}}};
  CHECK(to_csv(table) == "b,psi2\nb: -0.0045***,[1]\n-7.51e-05,*\n");
  CHECK_THAT(to_markdown(table),
             Catch::Matchers::Contains("| b: \u22120.0045\\*\\*\\* | \\[1\\] |") &&
                 Catch::Matchers::Contains("| \u22127.51e\u221205 | \\* |"));
  const std::string latex = to_latex(table);
  CHECK_THAT(latex, Catch::Matchers::Contains("b & $\\psi$$^2$ \\\\"));
  CHECK_THAT(latex, Catch::Matchers::Contains("b: $-0.0045$$^{***}$ & {[}1] \\\\"));
  CHECK_THAT(latex, Catch::Matchers::Contains("$-7.51\\times 10^{-5}$ & {*} \\\\"));
}

TEST_CASE("in LaTeX a long table continues on further pages, and long titles have several lines") {
  FormattedTable table{.name = "long",
                       .caption = "Long",
                       .columns = {{"aic", "Log-likelihood of all", ColumnKind::kCount}}};
  for (int i = 0; i < 100; ++i) table.rows.push_back({static_cast<double>(i)});
  const std::string latex = to_latex(table);
  std::size_t parts = 0;
  for (std::size_t at = latex.find("\\begin{table}"); at != std::string::npos;
       at = latex.find("\\begin{table}", at + 1)) {
    ++parts;
  }
  CHECK(parts == 3);
  CHECK_THAT(latex, Catch::Matchers::Contains("Log-likelihood\\\\of all\\end{tabular}"));
  CHECK_THAT(latex, Catch::Matchers::Contains("\\caption{Long (continued)}"));
}

TEST_CASE("in LaTeX sentences are wrapped") {
  const FormattedTable table{.name = "notes",
                             .caption = "Notes",
                             .columns = {{"k", "k", ColumnKind::kCount}, {"note", "Note"}},
                             .rows = {{1.0, std::string(41, 'x')}}};
  CHECK_THAT(to_latex(table), Catch::Matchers::Contains("\\begin{tabular}{rp{4cm}}"));
}
