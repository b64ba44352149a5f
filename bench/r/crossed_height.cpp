// SPDX-License-Identifier: MIT
// Heights with random effects of crossed or nested groups, for TMB: a of three groupings, and b of
// the first.
#include <TMB.hpp>

template <class Type>
Type objective_function<Type>::operator()() {
  DATA_VECTOR(H);
  DATA_VECTOR(D);
  DATA_IVECTOR(first);
  DATA_IVECTOR(second);
  DATA_IVECTOR(third);
  PARAMETER_VECTOR(beta);
  PARAMETER_VECTOR(factor);  // of the first grouping: l11, l21, l22 of a and 100 b
  PARAMETER_VECTOR(sd);      // of a, by the second and the third
  PARAMETER(log_sigma);
  PARAMETER_MATRIX(u);  // (2 x groups) standard normal
  PARAMETER_VECTOR(v);
  PARAMETER_VECTOR(w);
  Type value = 0;
  for (int k = 0; k < u.cols(); k++)
    value -= dnorm(vector<Type>(u.col(k)), Type(0), Type(1), true).sum();
  value -= dnorm(v, Type(0), Type(1), true).sum() + dnorm(w, Type(0), Type(1), true).sum();
  for (int i = 0; i < H.size(); i++) {
    Type a = beta(0) + factor(0) * u(0, first(i)) + sd(0) * v(second(i)) + sd(1) * w(third(i));
    Type b = (beta(1) + factor(1) * u(0, first(i)) + factor(2) * u(1, first(i))) / 100;
    value -= dnorm(H(i), 1.3 + a * (1 - exp(-b * D(i))), exp(log_sigma), true);
  }
  return value;
}
