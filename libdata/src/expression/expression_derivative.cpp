// SPDX-License-Identifier: MIT
#include "expression/expression_derivative.hpp"

#include <numbers>
#include <unordered_map>

namespace silvafit::data {
namespace {

NodePointer operator+(const NodePointer& a, const NodePointer& b) {
  return make_operation(Operation::kAdd, a, b);
}
NodePointer operator-(const NodePointer& a, const NodePointer& b) {
  return make_operation(Operation::kSubtract, a, b);
}
NodePointer operator*(const NodePointer& a, const NodePointer& b) {
  return make_operation(Operation::kMultiply, a, b);
}
NodePointer operator/(const NodePointer& a, const NodePointer& b) {
  return make_operation(Operation::kDivide, a, b);
}
NodePointer operator-(const NodePointer& a) { return make_operation(Operation::kNegate, a); }

const NodePointer& one() {
  static const NodePointer node = make_constant(1.0);
  return node;
}

const NodePointer& zero() {
  static const NodePointer node = make_constant(0.0);
  return node;
}

/// The derivatives of one graph; each shared part is differentiated once.
class Differentiation {
 public:
  /// \param at_limits  whether 0 times infinity is 0 in products, and 0 over 0 in quotients
  Differentiation(std::string_view variable, bool at_limits)
      : variable_(variable), at_limits_(at_limits) {}

  NodePointer of(const NodePointer& node) {
    const auto known = derivatives_.find(node.get());
    if (known != derivatives_.end()) return known->second;
    NodePointer result = compute(node);
    derivatives_.emplace(node.get(), result);
    return result;
  }

 private:
  NodePointer product(const NodePointer& a, const NodePointer& b) const {
    return at_limits_ ? make_limit_product(a, b) : a * b;
  }

  NodePointer quotient(const NodePointer& a, const NodePointer& b) const {
    return at_limits_ ? make_limit_product(a, one() / b) : a / b;
  }

  NodePointer compute(const NodePointer& node) {
    switch (node->operand_count) {
      case 0:
        return node->operation == Operation::kVariable && node->name == variable_ ? one() : zero();
      case 1: {
        const NodePointer inner = of(node->operands[0]);
        return is_constant(inner, 0.0) ? zero() : product(outer_of_one(node), inner);
      }
      default:
        return of_several(node);
    }
  }

  // df/du for f(u).
  static NodePointer outer_of_one(const NodePointer& node) {
    const NodePointer& u = node->operands[0];
    switch (node->operation) {
      case Operation::kNegate:
        return make_constant(-1.0);
      case Operation::kExp:
        return node;
      case Operation::kLog:
      case Operation::kLogFloored:
        return one() / u;
      case Operation::kLog10:
        return make_constant(1.0 / std::numbers::ln10) / u;
      case Operation::kLog2:
        return make_constant(1.0 / std::numbers::ln2) / u;
      case Operation::kLog1p:
        return one() / (one() + u);
      case Operation::kExpm1:
        return make_operation(Operation::kExp, u);
      case Operation::kSqrt:
        return make_constant(0.5) / node;
      case Operation::kAbs:
        return make_operation(Operation::kSign, u);
      default:
        return outer_trigonometric(node);
    }
  }

  static NodePointer outer_trigonometric(const NodePointer& node) {
    const NodePointer& u = node->operands[0];
    switch (node->operation) {
      case Operation::kSin:
        return make_operation(Operation::kCos, u);
      case Operation::kCos:
        return -make_operation(Operation::kSin, u);
      case Operation::kTan:
        return one() + node * node;
      case Operation::kAsin:
        return one() / make_operation(Operation::kSqrt, one() - u * u);
      case Operation::kAcos:
        return make_constant(-1.0) / make_operation(Operation::kSqrt, one() - u * u);
      case Operation::kAtan:
        return one() / (one() + u * u);
      case Operation::kSinh:
        return make_operation(Operation::kCosh, u);
      case Operation::kCosh:
        return make_operation(Operation::kSinh, u);
      case Operation::kTanh:
        return one() - node * node;
      default:
        return zero();  // sign and not: piecewise constant
    }
  }

  NodePointer of_several(const NodePointer& node) {
    const NodePointer& u = node->operands[0];
    const NodePointer& v = node->operands[1];
    switch (node->operation) {
      case Operation::kAdd:
        return of(u) + of(v);
      case Operation::kSubtract:
        return of(u) - of(v);
      case Operation::kMultiply:
      case Operation::kLimitProduct:
        return product(of(u), v) + product(u, of(v));
      case Operation::kDivide:
        return quotient(of(u) - product(node, of(v)), v);
      case Operation::kPower:
        return of_power(node);
      case Operation::kMin:
        return chosen(make_operation(Operation::kLessEqual, u, v), of(u), of(v));
      case Operation::kMax:
        return chosen(make_operation(Operation::kLessEqual, v, u), of(u), of(v));
      case Operation::kIfElse:
        return chosen(u, of(v), of(node->operands[2]));
      default:
        return zero();  // comparisons and logic: piecewise constant
    }
  }

  NodePointer of_power(const NodePointer& node) {
    const NodePointer& base = node->operands[0];
    const NodePointer& exponent = node->operands[1];
    const NodePointer by_base = product(
        product(exponent, make_operation(Operation::kPower, base, exponent - one())), of(base));
    const NodePointer by_exponent =
        product(product(node, make_operation(Operation::kLogFloored, base)), of(exponent));
    return by_base + by_exponent;
  }

  static NodePointer chosen(const NodePointer& condition,
                            const NodePointer& a,
                            const NodePointer& b) {
    return make_operation(Operation::kIfElse, condition, a, b);
  }

  std::string_view variable_;
  bool at_limits_;
  std::unordered_map<const ExpressionNode*, NodePointer> derivatives_;
};

}  // namespace

NodePointer differentiate(const NodePointer& node, std::string_view variable) {
  const bool at_limits = is_marked_for_limits(node);
  NodePointer result = Differentiation(variable, at_limits).of(node);
  return at_limits ? marked_for_limits(result) : result;
}

}  // namespace silvafit::data
