// SPDX-License-Identifier: MIT
#include "likelihood/other_modes.hpp"

namespace silvafit::fit {

bool take_lower(const EffectLayout& layout,
                const VectorXd& others,
                const VectorXd& of_others,
                VectorXd& modes,
                VectorXd& objectives) {
  constexpr double kLower = 1e-6;
  bool any = false;
  for (Index c = 0; c < objectives.size(); ++c) {
    if (!(of_others[c] < objectives[c] - kLower)) continue;
    const Index begin = layout.begin(c);
    const Index size = layout.begin(c + 1) - begin;
    modes.segment(begin, size) = others.segment(begin, size);
    objectives[c] = of_others[c];
    any = true;
  }
  return any;
}

std::vector<VectorXd> other_starts(const EffectLayout& layout) {
  const VectorXd none = VectorXd::Zero(layout.size());
  std::vector<VectorXd> starts{none};
  // Standard deviations.
  for (const double side : {2.0, -2.0, 1.0, -1.0}) {
    for (std::size_t t = layout.terms(); t-- > 0;) {
      for (Index k = 0; k < layout.count(t); ++k) {
        std::vector<MatrixXd> terms = layout.by_term(none);
        terms[t].row(k).setConstant(side);
        starts.push_back(layout.from_terms(terms));
      }
    }
  }
  return starts;
}

}  // namespace silvafit::fit
