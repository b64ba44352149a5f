// SPDX-License-Identifier: MIT
// A line each: a formula, sub-models of parameters, and one of random effects, for a small table.
#include <string>
#include <vector>

#include "fuzz_target.hpp"
#include "silvafit/data/program.hpp"
#include "silvafit/fit/model_specification.hpp"

namespace {

std::vector<std::string> lines_of(std::string_view bytes) {
  std::vector<std::string> lines;
  while (!bytes.empty()) {
    const std::size_t end = bytes.find('\n');
    lines.emplace_back(bytes.substr(0, end));
    bytes.remove_prefix(end == std::string_view::npos ? bytes.size() : end + 1);
  }
  return lines;
}

silvafit::data::Table small_table() {
  silvafit::data::Table table(3);
  table.set("dbh", {10.0, 20.0, 30.0});
  table.set("h", {8.0, 15.0, 19.0});
  silvafit::data::TextColumn plots;
  for (const char* plot : {"a", "a", "b"}) plots.append(plot);
  table.set("plot", std::move(plots));
  return table;
}

/// The formula and its derivatives, at all parameters 1.
void evaluate(const silvafit::fit::ModelSpecification& specification,
              const silvafit::data::Table& table) {
  using silvafit::data::Expression;
  const Expression& mean = specification.formula.right;
  std::vector<silvafit::data::Program::Input> inputs;
  std::vector<const double*> values;
  static const double one = 1.0;
  for (const std::string& name : mean.variables()) {
    const bool is_column = table.has(name) && table.is_numeric(name);
    inputs.push_back({name, !is_column});
    values.push_back(is_column ? table.numbers(name).data() : &one);
  }
  std::vector<Expression> outputs{mean};
  for (const auto& parameter : specification.parameters) {
    outputs.push_back(mean.derivative(parameter.name));
  }
  const silvafit::data::Program program(outputs, inputs);
  std::vector<std::vector<double>> results(outputs.size(), std::vector<double>(3));
  std::vector<double*> to;
  to.reserve(results.size());
  for (std::vector<double>& result : results) to.push_back(result.data());
  silvafit::data::Program::Workspace workspace;
  program.evaluate(values, 3, to, workspace);
}

}  // namespace

void silvafit::fuzz::read(std::string_view bytes) {
  static const data::Table table = small_table();
  const std::vector<std::string> lines = lines_of(bytes);
  if (lines.empty()) return;
  std::vector<std::string> sub_models(lines.begin() + 1, lines.end());
  const bool has_random = sub_models.size() > 1;
  const std::string random = has_random ? sub_models.back() : std::string();
  if (has_random) sub_models.pop_back();
  fit::ModelSpecification specification = fit::specify_model(lines.front(), sub_models, table);
  if (has_random) fit::add_random_effects(specification, random, table);
  evaluate(specification, table);
}
