// SPDX-License-Identifier: MIT
// TMB template: height curve with an effect of the stand on a and of the plot on a and b, both
// normal, and a power variance of the conditional mean. Parameters as in R: h = 1.3 + a (1 - exp(-b
// dbh / 10)).
#include <TMB.hpp>

template <class Type>
Type objective_function<Type>::operator()() {
  DATA_VECTOR(h);
  DATA_VECTOR(dbh);
  DATA_IVECTOR(stand);
  DATA_IVECTOR(plot);
  PARAMETER_VECTOR(beta);
  PARAMETER(log_sd_stand);
  PARAMETER_VECTOR(plot_factor);  // lower triangle of L by columns, Psi = L L'
  PARAMETER(log_sigma);
  PARAMETER(delta);
  PARAMETER_VECTOR(stand_effect);  // standard normal
  PARAMETER_MATRIX(plot_effect);   // (plots x 2) standard normal

  Type result = -dnorm(stand_effect, Type(0), Type(1), true).sum();
  for (int j = 0; j < plot_effect.rows(); j++) {
    for (int k = 0; k < 2; k++) result -= dnorm(plot_effect(j, k), Type(0), Type(1), true);
  }
  for (int i = 0; i < h.size(); i++) {
    Type u0 = plot_effect(plot(i), 0);
    Type u1 = plot_effect(plot(i), 1);
    Type a = beta(0) + exp(log_sd_stand) * stand_effect(stand(i)) + plot_factor(0) * u0;
    Type b = beta(1) + plot_factor(1) * u0 + plot_factor(2) * u1;
    Type mean = Type(1.3) + a * (Type(1) - exp(-b * dbh(i) / Type(10)));
    result -= dnorm(h(i), mean, exp(log_sigma + delta * log(mean)), true);
  }
  return result;
}
