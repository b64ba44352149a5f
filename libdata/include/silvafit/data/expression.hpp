// SPDX-License-Identifier: MIT
// Formulas as text, as graphs, and their derivatives.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit::data {

struct ExpressionNode;

/// An arithmetic expression of named variables; a value type that shares its immutable graph.
///
/// Text: numbers, names (letters, digits, `_`, `.`, or anything in backquotes), + - * / ^
/// (right-associative, binds tighter than the sign), comparisons < <= > >= == != (1 or 0), && || !,
/// parentheses, `name == "text"` for text columns, and the functions exp log log10 log2 log1p expm1
/// sqrt abs sign sin cos tan asin acos atan sinh cosh tanh pow min max ifelse; the constant pi.
/// I(...) is what it encloses. docs/formula-language.md describes them.
class Expression {
 public:
  /// \throws FormulaError with the column in `text`
  static Expression parse(std::string_view text);
  /// Parses the part [begin, end) of a longer text; errors give the column in the whole.
  static Expression parse(std::string_view whole, std::size_t begin, std::size_t end);
  static Expression constant(double value);
  static Expression variable(std::string_view name);

  /// Distinct variable names in the order of their first appearance. A comparison of a column with
  /// text is one variable, named `column == "text"`; see text_match.
  std::vector<std::string> variables() const;

  /// The symbolic derivative with respect to a variable, simplified.
  Expression derivative(std::string_view name) const;

  /// The same expression, whose derivatives of all orders take a product to be zero where a factor
  /// is zero and the other infinite. So it is at the edge of a domain where the value is finite:
  /// there exp(-b/x) and 1/(1 + exp((b - log(x))/c)) of x = 0 do not depend on b and c.
  Expression with_limits() const;

  /// The arguments of its sines, cosines and tangents.
  std::vector<Expression> periodic_arguments() const;

  /// The expression with a variable replaced.
  Expression substitute(std::string_view name, const Expression& replacement) const;

  /// Whether abs, sign, min, max, a comparison, logic or the condition of an ifelse depends on a
  /// variable: the derivative by it then jumps, which its symbolic form does not show.
  bool has_kink_in(std::string_view name) const;

  bool is_constant() const;
  bool is_zero() const;
  /// The value of a constant expression.
  double constant_value() const;

  /// The value for given variables, one at a time, for tests; of blocks: see Program.
  /// \param names, values  of equal length
  double value(const std::vector<std::string>& names, const std::vector<double>& values) const;

  /// Text that parses to the same expression.
  std::string text() const;

  const std::shared_ptr<const ExpressionNode>& node() const { return node_; }
  explicit Expression(std::shared_ptr<const ExpressionNode> node);

 private:
  std::shared_ptr<const ExpressionNode> node_;
};

Expression operator+(const Expression& a, const Expression& b);
Expression operator-(const Expression& a, const Expression& b);
Expression operator*(const Expression& a, const Expression& b);
Expression operator*(double a, const Expression& b);
Expression operator-(const Expression& a);
Expression exp(const Expression& a);
Expression log(const Expression& a);

/// `left ~ right` taken apart.
struct Formula {
  std::string left{};
  Expression right;
  std::string text{};
};

/// \throws FormulaError if there is no `~`, the left side is not a name, or the right side cannot
/// be read
Formula parse_formula(std::string_view text);

/// If a variable stands for `column == "text"`, its two parts.
struct TextMatch {
  std::string column{};
  std::string value{};
};
bool is_text_match(std::string_view variable, TextMatch& match);

}  // namespace silvafit::data
