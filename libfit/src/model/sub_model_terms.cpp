// SPDX-License-Identifier: MIT
#include "model/sub_model_terms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "silvafit/base/error.hpp"
#include "text/text_parts.hpp"

namespace silvafit::fit {
namespace {

using Terms = std::vector<Term>;

constexpr std::size_t kMostTerms = 500;
constexpr int kDeepest = 100;
constexpr int kHighestPower = 9;

/// Functions of R's formulas that are not available, and their replacements.
struct Advice {
  std::string_view function{};
  std::string_view advice{};
};
constexpr std::array kNotOffered = {
    Advice{"poly", "write the powers, such as x + I(x^2)"},
    Advice{"ns", "write the columns of the spline, such as x + I(max(x - 10, 0)^3)"},
    Advice{"bs", "write the columns of the spline, such as x + I(max(x - 10, 0)^3)"},
    Advice{"offset", "write terms without a coefficient into `formula`"},
    Advice{"scale", "write the numbers, such as I((x - 20)/5)"},
    Advice{"cut", "write comparisons, such as (x > 10) + (x > 20)"},
    Advice{"relevel",
           "write comparisons with the levels that differ from the first, such as (species == "
           "\"SM\")"},
    Advice{"interaction", "write factor:factor"},
    Advice{"ordered", "write factor(), whose contrasts are to the first level"},
    Advice{"as.numeric", "a comparison and a numeric column are numbers already"},
};

bool is_name_byte(char byte) {
  return std::isalnum(static_cast<unsigned char>(byte)) != 0 || byte == '_' || byte == '.';
}

bool is_digit_or_point(char byte) {
  return std::isdigit(static_cast<unsigned char>(byte)) != 0 || byte == '.';
}

bool is_same_term(const Term& a, const Term& b) { return std::ranges::is_permutation(a, b); }

bool contains(const Terms& terms, const Term& term) {
  return std::ranges::any_of(terms, [&](const Term& known) { return is_same_term(known, term); });
}

void add(const Terms& more, Terms& terms) {
  for (const Term& term : more) {
    if (!contains(terms, term)) terms.push_back(term);
  }
}

Term product(const Term& a, const Term& b) {
  Term result = a;
  for (const std::size_t variable : b) {
    if (std::ranges::find(result, variable) == result.end()) result.push_back(variable);
  }
  return result;
}

/// All products of two sums; it stops after one more than is allowed.
Terms products(const Terms& left, const Terms& right) {
  Terms result;
  for (const Term& a : left) {
    for (const Term& b : right) {
      add({product(a, b)}, result);
      if (result.size() > kMostTerms) return result;
    }
  }
  return result;
}

/// The position after the parenthesis that closes the one at `open`, or the end.
std::size_t behind_parenthesis(std::string_view text, std::size_t open, std::size_t end) {
  const std::size_t close = find_outside(text, {open + 1, end}, ")");
  return std::min(close + 1, end);
}

/// Reads the right side by splitting at operators, lowest precedence first.
class TermParser {
 public:
  explicit TermParser(std::string_view text) : text_(text) {}

  TermFormula parse() {
    const std::size_t tilde = text_.find('~');
    if (tilde == std::string_view::npos) {
      throw FormulaError("a sub-model has the form `parameter ~ 1 + covariate`; the ~ is missing",
                         text_,
                         text_.size() + 1);
    }
    result_.parameter = std::string(of(text_, trimmed(text_, 0, tilde)));
    result_.terms = sum({tilde + 1, text_.size()}, true);
    if (!result_.has_intercept && result_.terms.empty()) {
      throw FormulaError("a sub-model needs an intercept or a covariate", text_, tilde + 2);
    }
    std::ranges::stable_sort(result_.terms, {}, &Term::size);
    return std::move(result_);
  }

 private:
  struct Signed {
    Part part{};
    bool is_removed = false;
  };

  [[noreturn]] void fail(const std::string& message, std::size_t place) const {
    throw FormulaError(message, text_, place + 1);
  }

  [[noreturn]] void refuse(const std::string& what, Part part) const {
    fail(fmt::format("{}; write I({}) for the arithmetic", what, of(text_, part)), part.begin);
  }

  [[noreturn]] void refuse_number(std::string_view number, Part part) const {
    if (number == ".") fail("'.' for all columns is not supported; write their names", part.begin);
    const std::string what = fmt::format("the number {} is not a term", number);
    if (number != of(text_, part)) refuse(what, part);
    fail(what + "; arithmetic is written I(...), such as I(x - 5)", part.begin);
  }

  bool is_number(Part part) const {
    return is_digit_or_point(text_[part.begin]) &&
           find_outside(text_, part, "<>=!&|*:/^%") == part.end;
  }

  bool is_comparison(Part part) const { return find_outside(text_, part, "<>=!&|") < part.end; }

  /// The signs of a sum, without those of the numbers in `x > -3` and `x > 1e-3`.
  bool is_sign(std::size_t i, Part whole) const {
    const Part before = trimmed(text_, whole.begin, i);
    if (before.begin == before.end) return true;
    const bool is_compared =
        std::string_view("<>=!&|").find(text_[before.end - 1]) != std::string_view::npos;
    return !is_compared && !is_exponent(before);
  }

  /// Whether a text ends with the `1e` of a number such as 1e-3.
  bool is_exponent(Part before) const {
    if (text_[before.end - 1] != 'e' && text_[before.end - 1] != 'E') return false;
    std::size_t begin = before.end;
    while (begin > before.begin && is_name_byte(text_[begin - 1])) --begin;
    return is_digit_or_point(text_[begin]);
  }

  std::vector<Signed> signed_parts(Part whole) const {
    std::vector<Signed> parts;
    std::size_t begin = whole.begin;
    bool is_removed = false;
    for (std::size_t i = begin; i < whole.end; ++i) {
      i = find_outside(text_, {i, whole.end}, "+-");
      if (i == whole.end || !is_sign(i, whole)) continue;
      const Part part = trimmed(text_, begin, i);
      const bool is_leading_minus = text_[i] == '-' && parts.empty() && part.begin == part.end;
      if (!is_leading_minus) parts.push_back({part, is_removed});
      is_removed = text_[i] == '-';
      begin = i + 1;
    }
    parts.push_back({trimmed(text_, begin, whole.end), is_removed});
    return parts;
  }

  Terms sum(Part whole, bool is_outermost) {
    if (++depth_ > kDeepest) fail("the sub-model is nested too deeply", whole.begin);
    Terms terms;
    const std::vector<Signed> parts = signed_parts(whole);
    const bool has_minus = std::ranges::any_of(parts, &Signed::is_removed);
    for (const auto& [part, is_removed] : parts) {
      const std::string_view term = of(text_, part);
      if (term.empty()) fail("expected a covariate", part.begin);
      if (has_minus && is_comparison(part)) {
        fail("a comparison next to a minus sign needs parentheses: (x > 3)", part.begin);
      }
      if (term == "0" || term == "1") {
        set_intercept(part, is_removed, is_outermost, trimmed(text_, whole.begin, whole.end));
      } else if (is_number(part)) {
        refuse_number(term, is_outermost ? part : trimmed(text_, whole.begin, whole.end));
      } else if (is_removed) {
        remove(part, terms);
      } else {
        add(comparison_or_product(part), terms);
      }
      if (terms.size() > kMostTerms) fail("the sub-model has too many terms", part.begin);
    }
    --depth_;
    return terms;
  }

  void set_intercept(Part part, bool is_removed, bool is_outermost, Part whole) {
    const bool is_one = text_[part.begin] == '1';
    if (!is_outermost) refuse("a number in parentheses is not a term", whole);
    if (is_removed && !is_one) fail("write `0 +` or `- 1` to leave out the intercept", part.begin);
    result_.has_intercept = is_one && !is_removed;
  }

  void remove(Part part, Terms& terms) {
    const Terms removed = comparison_or_product(part);
    for (const Term& term : removed) {
      if (contains(terms, term)) continue;
      fail(fmt::format("there is no term '{0}' to remove with -; write a difference of columns as "
                       "{1}",
                       label_of(term),
                       terms.empty() ? fmt::format("I(-{})", label_of(term))
                                     : fmt::format("I(x - {})", label_of(term))),
           part.begin);
    }
    std::erase_if(terms, [&](const Term& term) { return contains(removed, term); });
  }

  Terms comparison_or_product(Part part) {
    if (!is_comparison(part)) return crossed(part);
    if (find_outside(text_, part, ":") < part.end) {
      fail("a comparison in a product needs parentheses: (x > 3):z", part.begin);
    }
    return {{variable(part)}};
  }

  /// a*b is a + b + a:b.
  Terms crossed(Part part) {
    refuse_operators(part);
    Terms terms;
    for (const Part factor : split(text_, part.begin, part.end, '*')) {
      const Terms right = interaction(factor, part);
      const Terms both = products(terms, right);
      add(right, terms);
      add(both, terms);
      if (terms.size() > kMostTerms) fail("the sub-model has too many terms", part.begin);
    }
    return terms;
  }

  void refuse_operators(Part part) const {
    if (find_outside(text_, part, "/") < part.end) {
      refuse("in R's formulas a/b is a + a:b, not a quotient", part);
    }
    if (const std::size_t place = find_outside(text_, part, "%"); place < part.end) {
      fail("%in% and other % operators are not supported; write a:b instead of a %in% b", place);
    }
  }

  Terms interaction(Part part, Part whole) {
    Terms terms;
    for (const Part factor : split(text_, part.begin, part.end, ':')) {
      if (factor.begin == factor.end) {
        fail("expected a covariate on both sides of : and *", factor.begin);
      }
      const Terms right = power(factor, whole);
      terms = terms.empty() ? right : products(terms, right);
      if (terms.size() > kMostTerms) fail("the sub-model has too many terms", part.begin);
    }
    return terms;
  }

  /// (a + b)^2 is a + b + a:b.
  Terms power(Part part, Part whole) {
    const std::size_t sign = find_outside(text_, part, "^");
    if (sign == part.end) return atom(part, whole);
    const Terms base = atom(trimmed(text_, part.begin, sign), whole);
    if (base.size() < 2) refuse("in R's formulas x^2 is x itself, not its square", part);
    const std::string_view exponent = of(text_, trimmed(text_, sign + 1, part.end));
    const bool is_digit = exponent.size() == 1 && exponent[0] >= '1' && exponent[0] <= '9';
    if (!is_digit) fail(fmt::format("expected a number from 1 to {}", kHighestPower), sign + 1);
    Terms terms = base;
    for (int k = 1; k < exponent[0] - '0'; ++k) {
      terms = products(terms, base);
      if (terms.size() > kMostTerms) fail("the sub-model has too many terms", part.begin);
    }
    return terms;
  }

  /// \param whole  the product around it, for advice
  Terms atom(Part part, Part whole) {
    const bool is_enclosed = text_[part.begin] == '(' &&
                             behind_parenthesis(text_, part.begin, part.end) == part.end &&
                             text_[part.end - 1] == ')';
    if (is_enclosed && !is_comparison({part.begin + 1, part.end - 1})) {
      return sum({part.begin + 1, part.end - 1}, false);
    }
    if (is_digit_or_point(text_[part.begin])) refuse_number(of(text_, part), whole);
    return {{variable(part)}};
  }

  std::size_t variable(Part part) {
    TermVariable read = read_variable(part);
    const std::string text = read.value.text();
    for (std::size_t k = 0; k < result_.variables.size(); ++k) {
      const TermVariable& known = result_.variables[k];
      if (known.is_factor == read.is_factor && known.value.text() == text) return k;
    }
    result_.variables.push_back(std::move(read));
    return result_.variables.size() - 1;
  }

  TermVariable read_variable(Part part) const {
    const std::string_view label = of(text_, part);
    const std::string_view function = function_called(part);
    const auto advice = std::ranges::find(kNotOffered, function, &Advice::function);
    if (advice != kNotOffered.end()) {
      fail(fmt::format("{}() is not supported in sub-models; {}", function, advice->advice),
           part.begin);
    }
    if (function == "factor" || function == "as.factor") return read_factor(part);
    TermVariable result{.label = std::string(label),
                        .value = data::Expression::parse(text_, part.begin, part.end),
                        .position = part.begin + 1};
    const std::vector<std::string> names = result.value.variables();
    // The name that stands for a comparison with text is a variable of the expression, too.
    const bool is_name =
        names.size() == 1 && function.empty() && !is_comparison(part) && label[0] != '(';
    if (is_name) result.column = names.front();
    return result;
  }

  std::string_view function_called(Part part) const {
    const std::size_t open = find_outside(text_, part, "(");
    if (open == part.end || open == part.begin) return {};
    if (behind_parenthesis(text_, open, part.end) != part.end) return {};
    const std::string_view name = of(text_, trimmed(text_, part.begin, open));
    return std::ranges::all_of(name, is_name_byte) ? name : std::string_view();
  }

  TermVariable read_factor(Part part) const {
    const std::size_t open = find_outside(text_, part, "(");
    const Part inside = trimmed(text_, open + 1, part.end - 1);
    const data::Expression value = data::Expression::parse(text_, inside.begin, inside.end);
    const std::vector<std::string> names = value.variables();
    data::TextMatch match;
    const bool is_column = names.size() == 1 &&
                           value.text() == data::Expression::variable(names[0]).text() &&
                           !data::is_text_match(names[0], match);
    if (!is_column) fail("factor() takes one column name", inside.begin);
    return {.label = std::string(of(text_, part)),
            .value = value,
            .column = names.front(),
            .is_factor = true,
            .position = part.begin + 1};
  }

  std::string label_of(const Term& term) const {
    std::vector<std::string> labels;
    for (const std::size_t variable : term) labels.push_back(result_.variables[variable].label);
    return product_label(labels);
  }

  std::string_view text_;
  TermFormula result_;
  int depth_ = 0;
};

}  // namespace

std::string product_label(const std::vector<std::string>& labels) {
  return fmt::format("{}", fmt::join(labels, ":"));
}

TermFormula parse_terms(std::string_view text) { return TermParser(text).parse(); }

}  // namespace silvafit::fit
