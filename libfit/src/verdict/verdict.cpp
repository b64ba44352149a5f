// SPDX-License-Identifier: MIT
// The convergence message from the findings of a fit.
#include <fmt/args.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "silvafit/base/text.hpp"
#include "silvafit/fit/finding.hpp"
#include "verdict/verdict_texts.hpp"

namespace silvafit::fit {
namespace {

constexpr std::string_view kUnbounded =
    "{names} [goes|go] to a limit of the curve (infinity, zero or a step): the data do not cover "
    "the "
    "part of the curve that [it describes|they describe]. Use a model with fewer coefficients.";

/// "fewer random effects or a simpler variance function", as far as the model has them.
std::string simpler(const Reducible& model) {
  std::vector<std::string> ways;
  if (model.effects) ways.emplace_back("fewer random effects");
  if (model.covariances) ways.emplace_back("a diagonal covariance matrix");
  if (model.variance) ways.emplace_back("a simpler variance function");
  if (model.correlation) ways.emplace_back("a simpler correlation of the residuals");
  return ways.empty() ? "a curve with fewer coefficients" : enumerated(ways, "or");
}

/// "a = 1.2, b = 3": the names with the last values.
std::string point(const Finding& finding) {
  std::vector<std::string> parts;
  const std::size_t others = finding.values.size() - finding.names.size();
  for (std::size_t k = 0; k < finding.names.size(); ++k) {
    parts.push_back(fmt::format("{} = {:.4g}", finding.names[k], finding.values[others + k]));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

bool is_one(const Finding& finding) {
  if (!finding.names.empty()) return finding.names.size() == 1;
  return !finding.values.empty() && finding.values.front() == 1.0;
}

/// The text with one of each [one|several].
std::string chosen(std::string text, bool one) {
  for (std::size_t begin = 0; (begin = text.find('[')) != std::string::npos;) {
    const std::size_t middle = text.find('|', begin);
    const std::size_t end = text.find(']', middle);
    const std::string taken = one ? text.substr(begin + 1, middle - begin - 1)
                                  : text.substr(middle + 1, end - middle - 1);
    text.replace(begin, end + 1 - begin, taken);
  }
  return text;
}

std::string sentence(const Finding& finding) {
  std::string text(text_of(finding.kind));
  if (const std::size_t at = text.find("{unbounded}"); at != std::string::npos) {
    text = text.substr(0, at).append(kUnbounded);
  }
  fmt::dynamic_format_arg_store<fmt::format_context> arguments;
  const auto add = [&arguments](const char* name, const auto& value) {
    arguments.push_back(fmt::arg(name, value));
  };
  add("names", enumerated(finding.names));
  add("each", fmt::format("{}", fmt::join(finding.names, "; ")));
  add("simpler", simpler(finding.reducible));
  if (finding.values.size() >= finding.names.size()) add("point", point(finding));
  constexpr std::array kNames{"a", "b", "c"};
  for (std::size_t k = 0; k < std::min(kNames.size(), finding.names.size()); ++k) {
    add(kNames[k], finding.names[k]);
  }
  constexpr std::array kValues{"x", "y", "z"};
  for (std::size_t k = 0; k < std::min(kValues.size(), finding.values.size()); ++k) {
    add(kValues[k], finding.values[k]);
  }
  return fmt::vformat(chosen(std::move(text), is_one(finding)), arguments);
}

void append(const std::string& sentence, std::string& text) {
  if (sentence.empty()) return;
  text += (text.empty() ? "" : " ") + sentence;
}

}  // namespace

std::string verdict_of(const std::vector<Finding>& findings) {
  std::string before;
  std::string result;
  std::string after;
  for (const Finding& finding : findings) {
    std::string said = sentence(finding);
    if (finding.kind < Finding::Kind::kFirstBefore) {
      result = std::move(said);
    } else if (finding.kind < Finding::Kind::kFirstAfter) {
      append(before, said);
      before = std::move(said);
    } else {
      append(said, after);
    }
  }
  append(result, before);
  append(after, before);
  return before;
}

}  // namespace silvafit::fit
