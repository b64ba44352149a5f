// SPDX-License-Identifier: MIT
#include "expression/expression_parser.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "expression/operation.hpp"
#include "expression/self_starting_models.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::data {
namespace {

// Deeper nesting is an error, because it could overflow the stack.
constexpr int kDeepest = 200;
constexpr std::size_t kLongest = 10000;

bool is_digit(char byte) { return byte >= '0' && byte <= '9'; }

/// Signs of printed formulas and word processors, which are no letters of names.
struct PrintedSign {
  std::string_view sign{};
  std::string_view typed{};
};
constexpr std::array<PrintedSign, 24> kPrintedSigns{
    {{"×", "*"},
     {"·", "*"},
     {"⋅", "*"},
     {"∗", "*"},
     {"÷", "/"},
     {"∕", "/"},
     {"−", "-"},
     {"–", "-"},
     {"²", "^2"},
     {"³", "^3"},
     {"ˆ", "^"},
     {"√", "sqrt()"},
     {"≤", "<="},
     {"≥", ">="},
     {"≠", "!="},
     {"∼", "~"},
     {"“", "\""},
     {"”", "\""},
     {"„", "\""},
     {"\u00a0", "a plain blank"},
     {"\u2009", "a plain blank"},
     {"\u202f", "a plain blank"},
     {"\u200b", "nothing in place of this invisible sign"},
     {"\ufeff", "nothing in place of this invisible sign"}}};

/// The first printed sign in a name; none in most.
struct FoundSign {
  const PrintedSign* sign = nullptr;
  std::size_t place = std::string_view::npos;
};
FoundSign find_printed_sign(std::string_view name) {
  FoundSign first;
  for (const PrintedSign& sign : kPrintedSigns) {
    const std::size_t place = name.find(sign.sign);
    if (place < first.place) first = {&sign, place};
  }
  return first;
}

bool starts_name(char byte) { return is_name_byte(byte) && !is_digit(byte) && byte != '.'; }

/// Recursive descent over the text, loosest binding first.
class Parser {
 public:
  /// \param arguments  what %1, %2, ... stand for, in formulas of self-starting models
  Parser(std::string_view text,
         std::size_t begin,
         std::size_t end,
         const std::vector<NodePointer>* arguments = nullptr)
      : text_(text), position_(begin), end_(end), arguments_(arguments) {}

  NodePointer parse() {
    NodePointer result = either();
    skip_blanks();
    if (position_ < end_) fail_here();
    return result;
  }

  /// The names in the text, and where they stand.
  const std::vector<NamePlace>& names() const { return names_; }

 private:
  NodePointer named(std::string name, std::size_t position) {
    names_.push_back({.name = name, .position = position + 1});
    return make_variable(std::move(name));
  }

  [[noreturn]] void fail(const std::string& message) const { fail_at(message, position_); }
  [[noreturn]] void fail_at(const std::string& message, std::size_t position) const {
    throw FormulaError(message, text_, position + 1);
  }

  void skip_blanks() {
    while (position_ < end_ && (text_[position_] == ' ' || text_[position_] == '\t' ||
                                text_[position_] == '\n' || text_[position_] == '\r')) {
      ++position_;
    }
  }

  char peek() {
    skip_blanks();
    return position_ < end_ ? text_[position_] : '\0';
  }

  bool accept(std::string_view token) {
    skip_blanks();
    if (text_.substr(position_, end_ - position_).substr(0, token.size()) != token) return false;
    position_ += token.size();
    return true;
  }

  void expect(std::string_view token, const char* after) {
    if (accept(token)) return;
    if (position_ >= end_) {
      fail(fmt::format("expected '{}' {}, but the formula ends here", token, after));
    }
    if (advice_on(text_[position_])[0] != '\0') fail_here();
    fail(fmt::format("expected '{}' {}", token, after));
  }

  /// Operators of R's formulas that an expression does not have.
  static const char* advice_on(char byte) {
    switch (byte) {
      case '|':
        return "; random effects are given by `random=a | plot`, and a logical or is ||";
      case '~':
        return "; a formula has one ~, and random effects are given by `random=a | plot`";
      case ':':
        return "; terms such as x:z belong into a sub-model (`parameters`), and a product has its "
               "parameter, as in b*x*z";
      case '%':
        return "; operators such as %in% are not available, compare by == and join by ||";
      default:
        return "";
    }
  }

  /// Refuses a sign that would make a name of what is written as an operation.
  void refuse_printed_sign(std::string_view name, std::size_t begin) const {
    const FoundSign found = find_printed_sign(name);
    if (found.sign == nullptr) return;
    fail_at(
        fmt::format("'{}' is not a letter of a name; write {}, or put a name that contains it in "
                    "backquotes",
                    found.sign->sign,
                    found.sign->typed),
        begin + found.place);
  }

  [[noreturn]] void fail_here() const {
    std::size_t end = position_;
    while (end < end_ && is_name_byte(text_[end])) ++end;
    refuse_printed_sign(text_.substr(position_, end - position_), position_);
    fail(fmt::format("unexpected '{}'{}", text_.substr(position_, 1), advice_on(text_[position_])));
  }

  NodePointer either() {
    const std::size_t begin = position_;
    NodePointer left = both();
    while (accept("||")) {
      // (1 || plot) of R's lme4 is a random effect.
      const std::size_t bars = position_ - 2;
      if (is_number(begin, bars)) {
        fail_at(fmt::format("'||' joins conditions, not numbers{}", advice_on('|')), bars);
      }
      const std::size_t right = position_;
      left = make_operation(Operation::kOr, left, both());
      require_condition(right);
    }
    return left;
  }

  /// `sp == 10 || 20` would be true for every row.
  void require_condition(std::size_t begin) const {
    if (!is_number(begin, position_)) return;
    fail_at("a number is no condition; write each comparison, as in sp == 10 || sp == 20", begin);
  }

  /// Whether a part of the text is a number, which is no condition.
  bool is_number(std::size_t begin, std::size_t end) const {
    return std::ranges::all_of(text_.substr(begin, end - begin), [](char byte) {
      return is_digit(byte) || byte == '.' || byte == ' ';
    });
  }

  NodePointer both() {
    NodePointer left = comparison();
    while (accept("&&")) {
      const std::size_t right = position_;
      left = make_operation(Operation::kAnd, left, comparison());
      require_condition(right);
    }
    return left;
  }

  NodePointer comparison() {
    skip_blanks();
    const std::size_t begin = position_;
    if (at_text()) return text_comparison(begin);
    NodePointer left = sum();
    if (accept("==")) return equality(left, begin, true);
    if (accept("!=")) return equality(left, begin, false);
    if (accept("<=")) return make_operation(Operation::kLessEqual, left, sum());
    if (accept(">=")) return make_operation(Operation::kLessEqual, sum(), left);
    if (accept("<")) return make_operation(Operation::kLess, left, sum());
    if (accept(">")) return make_operation(Operation::kLess, sum(), left);
    return left;
  }

  NodePointer equality(const NodePointer& left, std::size_t begin, bool equal) {
    NodePointer result;
    if (at_text()) {
      if (left->operation != Operation::kVariable)
        fail_at("text can only be compared with a column", begin);
      result = make_variable(text_match_name(left->name, quoted()));
    } else {
      result = make_operation(Operation::kEqual, left, sum());
    }
    return equal ? result : make_operation(Operation::kNot, result);
  }

  // "SM" == species
  NodePointer text_comparison(std::size_t begin) {
    const std::string value = quoted();
    const bool equal = accept("==");
    if (!equal && !accept("!=")) fail_at("text can only be compared with a column", begin);
    skip_blanks();
    const std::size_t right_begin = position_;
    const NodePointer right = sum();
    if (right->operation != Operation::kVariable) {
      fail_at("text can only be compared with a column", right_begin);
    }
    NodePointer match = make_variable(text_match_name(right->name, value));
    return equal ? match : make_operation(Operation::kNot, match);
  }

  bool at_text() {
    const char next = peek();
    return next == '"' || next == '\'';
  }

  std::string quoted() {
    const char quote = peek();
    const std::size_t begin = position_++;
    std::string value;
    for (; position_ < end_ && text_[position_] != quote; ++position_) value += text_[position_];
    if (position_ >= end_) fail_at("the closing quote is missing", begin);
    ++position_;
    return value;
  }

  NodePointer sum() {
    NodePointer left = product();
    for (;;) {
      if (accept("+")) {
        left = make_operation(Operation::kAdd, left, product());
      } else if (peek() == '-') {
        ++position_;
        left = make_operation(Operation::kSubtract, left, product());
      } else {
        return left;
      }
    }
  }

  NodePointer product() {
    NodePointer left = signed_power();
    for (;;) {
      if (accept("*")) {
        left = make_operation(Operation::kMultiply, left, signed_power());
      } else if (accept("/")) {
        left = make_operation(Operation::kDivide, left, signed_power());
      } else {
        return left;
      }
    }
  }

  NodePointer signed_power() {
    const Nesting nesting(*this);
    if (accept("-")) return make_operation(Operation::kNegate, signed_power());
    if (accept("+")) return signed_power();
    if (peek() == '!') {
      ++position_;
      return make_operation(Operation::kNot, signed_power());
    }
    NodePointer base = primary();
    if (!accept("^")) return base;
    return make_operation(Operation::kPower, base, signed_power());
  }

  NodePointer primary() {
    const char next = peek();
    if (next == '\0') fail("expected a value, but the formula ends here");
    if (accept("(")) {
      NodePointer inner = either();
      expect(")", "to close the parenthesis");
      return inner;
    }
    if (is_digit(next) || next == '.') return number();
    if (next == '`') return backquoted();
    if (next == '%' && arguments_ != nullptr) {
      position_ += 2;
      return arguments_->at(static_cast<std::size_t>(text_[position_ - 1] - '1'));
    }
    if (starts_name(next)) return name_or_call();
    fail(fmt::format("expected a value, not '{}'", next));
  }

  NodePointer number() {
    double value = 0.0;
    const char* first = text_.data() + position_;
    const auto [after, status] = std::from_chars(first, text_.data() + end_, value);
    if (status != std::errc()) {
      fail("this is not a number, and '.' does not stand for all columns; write their names");
    }
    position_ += static_cast<std::size_t>(after - first);
    if (position_ < end_ && starts_name(text_[position_])) {
      fail(fmt::format("expected an operator before '{}'", text_.substr(position_, 1)));
    }
    return make_constant(value);
  }

  NodePointer backquoted() {
    const std::size_t begin = position_++;
    const std::size_t close = text_.find('`', position_);
    if (close == std::string_view::npos || close >= end_)
      fail_at("the closing quote is missing", begin);
    std::string name(text_.substr(position_, close - position_));
    position_ = close + 1;
    return named(std::move(name), begin);
  }

  NodePointer name_or_call() {
    const std::size_t begin = position_;
    while (position_ < end_ && is_name_byte(text_[position_])) ++position_;
    const std::string_view name = text_.substr(begin, position_ - begin);
    refuse_printed_sign(name, begin);
    if (peek() == '(') return call(name, begin);
    if (name == "pi") return make_constant(std::numbers::pi);
    return named(std::string(name), begin);
  }

  NodePointer call(std::string_view name, std::size_t begin) {
    if (name == "I") return primary();  // as in R's formulas; everything is arithmetic here
    const SelfStartingModel* const model = find_self_starting_model(name);
    if (model != nullptr) return self_starting(*model, begin);
    const auto function = find_function(name);
    if (!function) {
      fail_at(fmt::format("unknown function '{}'{}", name, advice_on_function(name)), begin);
    }
    expect("(", "before the arguments");
    std::vector<NodePointer> arguments;
    do {
      arguments.push_back(either());
    } while (accept(","));
    expect(")", "after the arguments");
    return applied(*function, arguments, begin);
  }

  /// A self-starting model of R. As there, unnamed arguments are those that have no name, in order.
  NodePointer self_starting(const SelfStartingModel& model, std::size_t begin) {
    std::vector<NodePointer> arguments(model.size());
    std::vector<NodePointer> unnamed;
    std::size_t count = 0;
    expect("(", "before the arguments");
    do {
      const std::optional<std::size_t> place = argument_name(model);
      const NodePointer value = either();
      place ? arguments[*place] = value : unnamed.emplace_back(value);
      ++count;
    } while (accept(","));
    expect(")", "after the arguments");
    auto next = unnamed.begin();
    for (NodePointer& argument : arguments) {
      if (argument == nullptr && next != unnamed.end()) argument = *next++;
    }
    if (count != model.size() || std::ranges::find(arguments, nullptr) != arguments.end()) {
      fail_at(fmt::format("the arguments are {}", model.call()), begin);
    }
    return Parser(model.formula, 0, model.formula.size(), &arguments).parse();
  }

  /// Reads `name =` before an argument; no value if it has none.
  std::optional<std::size_t> argument_name(const SelfStartingModel& model) {
    skip_blanks();
    const std::size_t begin = position_;
    while (position_ < end_ && is_name_byte(text_[position_])) ++position_;
    const std::string_view name = text_.substr(begin, position_ - begin);
    const bool is_name = accept("=") && peek() != '=';
    if (!is_name) {
      position_ = begin;
      return std::nullopt;
    }
    const std::size_t place = model.place_of(name);
    if (place == model.size()) fail_at(fmt::format("the arguments are {}", model.call()), begin);
    return place;
  }

  NodePointer applied(const Function& function,
                      const std::vector<NodePointer>& arguments,
                      std::size_t begin) const {
    const bool folds =
        function.operation == Operation::kMin || function.operation == Operation::kMax;
    const auto count = static_cast<int>(arguments.size());
    if (count != function.arguments && !(folds && count > 2)) {
      fail_at(fmt::format("{} takes {} argument{}, not {}",
                          function.name,
                          function.arguments,
                          function.arguments == 1 ? "" : "s",
                          count),
              begin);
    }
    if (count == 1) return make_operation(function.operation, arguments[0]);
    if (function.operation == Operation::kIfElse) {
      return make_operation(function.operation, arguments[0], arguments[1], arguments[2]);
    }
    NodePointer result = arguments[0];
    for (std::size_t i = 1; i < arguments.size(); ++i) {
      result = make_operation(function.operation, result, arguments[i]);
    }
    return result;
  }

  struct Nesting {
    explicit Nesting(Parser& owner) : parser(owner) {
      if (++parser.depth_ > kDeepest) parser.fail("the formula has too many nested parentheses");
    }
    ~Nesting() { --parser.depth_; }
    Nesting(const Nesting&) = delete;
    Nesting& operator=(const Nesting&) = delete;
    Parser& parser;
  };

  std::string_view text_;
  std::size_t position_;
  std::size_t end_;
  const std::vector<NodePointer>* arguments_;
  std::vector<NamePlace> names_{};
  int depth_ = 0;
};

}  // namespace

bool is_name_byte(char byte) {
  return (byte >= 'a' && byte <= 'z') || (byte >= 'A' && byte <= 'Z') || is_digit(byte) ||
         byte == '_' || byte == '.' || static_cast<unsigned char>(byte) >= 0x80U;
}

bool is_plain_name(std::string_view name) {
  return !name.empty() && name != "pi" && starts_name(name[0]) &&
         std::ranges::all_of(name, is_name_byte) && find_printed_sign(name).sign == nullptr;
}

std::string text_match_name(std::string_view column, std::string_view value) {
  return fmt::format("{} == \"{}\"", column, value);
}

NodePointer parse_part(std::string_view text,
                       std::size_t begin,
                       std::size_t end,
                       std::vector<NamePlace>* names) {
  if (end - begin > kLongest) {
    throw FormulaError(fmt::format("the formula is longer than {} characters", kLongest), "", 1);
  }
  Parser parser(text, begin, end);
  NodePointer result = parser.parse();
  if (names != nullptr) *names = parser.names();
  return result;
}

}  // namespace silvafit::data
