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
/// I(...) has the value of its argument. docs/formula-language.md describes them.
class Expression {
 public:
  /// \throws FormulaError with the column in `text`
  static Expression parse(std::string_view text);
  /// Parses the part [begin, end) of a longer text. Errors give the column in the whole text.
  static Expression parse(std::string_view whole, std::size_t begin, std::size_t end);
  static Expression constant(double value);
  static Expression variable(std::string_view name);

  /// Distinct variable names in the order of their first appearance. A comparison of a column with
  /// text is one variable, named `column == "text"`; see text_match.
  std::vector<std::string> variables() const;

  /// The symbolic derivative with respect to a variable, simplified.
  Expression derivative(std::string_view name) const;

  /// The same expression, but in its derivatives of all orders a product with a factor zero is
  /// zero, even if the other factor is infinite or undefined. This is their limit at the edge of a
  /// domain where the value is finite: at x = 0, exp(-b/x), (x/b)^c and 1/(1 + exp((b - log(x))/c))
  /// do not depend on b and c.
  Expression with_limits() const;

  /// The arguments of its sines, cosines and tangents.
  std::vector<Expression> periodic_arguments() const;

  /// The expression with a variable replaced.
  Expression substitute(std::string_view name, const Expression& replacement) const;

  /// Whether abs, sign, min, max, a comparison, a logical operator or the condition of an ifelse
  /// depends on a variable. The derivative with respect to it then has jumps, which the symbolic
  /// form does not show.
  bool has_kink_in(std::string_view name) const;

  bool is_constant() const;
  bool is_zero() const;
  /// The value of a constant expression.
  double constant_value() const;

  /// The value for one set of variables. Program evaluates blocks of rows.
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

/// The two sides of `left ~ right`.
struct Formula {
  std::string left{};  ///< the name of a column, or the text of an expression: "h", "log(h)"
  Expression right;
  std::string text{};
};

/// \throws FormulaError if there is no `~`, the left side has no column, or a side cannot be
///   parsed
Formula parse_formula(std::string_view text);

/// The two parts of a variable `column == "text"`.
struct TextMatch {
  std::string column{};
  std::string value{};
};
bool is_text_match(std::string_view variable, TextMatch& match);

}  // namespace silvafit::data
