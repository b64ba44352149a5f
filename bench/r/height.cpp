// SPDX-License-Identifier: MIT
// TMB template of the timed model: effects of the plot on a and b, power or constant variance.
#include <TMB.hpp>

template <class Type>
Type objective_function<Type>::operator()() {
  DATA_VECTOR(H);
  DATA_VECTOR(D);
  DATA_VECTOR(C);
  DATA_IVECTOR(plot);
  PARAMETER_VECTOR(beta);         // a, 100 b, 100 b:C
  PARAMETER_VECTOR(plot_factor);  // lower triangle of L by columns, Psi = L L', in these units
  PARAMETER(log_sigma);
  PARAMETER(delta);
  PARAMETER_MATRIX(effect);  // (2 x plots) standard normal

  Type result = 0;
  for (int j = 0; j < effect.cols(); j++) {
    for (int k = 0; k < 2; k++) result -= dnorm(effect(k, j), Type(0), Type(1), true);
  }
  for (int i = 0; i < H.size(); i++) {
    Type u0 = effect(0, plot(i));
    Type u1 = effect(1, plot(i));
    Type a = beta(0) + plot_factor(0) * u0;
    Type b = (beta(1) + plot_factor(1) * u0 + plot_factor(2) * u1 + beta(2) * C(i)) / Type(100);
    Type mean = Type(1.3) + a * (Type(1) - exp(-b * D(i)));
    result -= dnorm(H(i), mean, exp(log_sigma + delta * log(mean / Type(20))), true);
  }
  return result;
}
