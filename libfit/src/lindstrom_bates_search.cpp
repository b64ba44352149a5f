// SPDX-License-Identifier: MIT
#include "lindstrom_bates_search.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <utility>

#include "silvafit/fit/fit_statistics.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Two log-likelihoods that differ by less are the same but for rounding.
constexpr double kSameLikelihood = 1e-7;

/// The log-likelihood of the start without random effects, which every mixed model contains.
double pooled_log_likelihood(const NonlinearModel& model, const VectorXd& start) {
  NonlinearModel::Workspace workspace;
  VectorXd mean;
  model.evaluate(start, mean, nullptr, workspace);
  return least_squares_log_likelihood((model.response() - mean).squaredNorm(),
                                      model.observations());
}

/// One run, and further ones from inside if it stopped on the edge while the likelihood rises
/// inwards.
LindstromBatesOutcome run_from(LindstromBates& engine,
                               const LindstromBatesState& start,
                               int maximum_iterations) {
  LindstromBatesOutcome outcome = engine.run(start, maximum_iterations);
  LindstromBatesState inside;
  constexpr int kAttempts = 3;
  for (int attempt = 0; attempt < kAttempts && engine.leave_edge(outcome, inside); ++attempt) {
    LindstromBatesOutcome moved = engine.run(inside, maximum_iterations);
    if (!moved.is_valid || moved.log_likelihood <= outcome.log_likelihood + kSameLikelihood) break;
    outcome = std::move(moved);
  }
  return outcome;
}

bool is_better(const LindstromBatesOutcome& a, const LindstromBatesOutcome& b) {
  if (!a.is_valid || !b.is_valid) return a.is_valid;
  if (a.converged != b.converged) return a.converged;
  return a.log_likelihood > b.log_likelihood + kSameLikelihood;
}

/// The best of several runs; a run counts as converged only above the pooled fit.
class Search {
 public:
  Search(LindstromBates& engine, double pooled, int maximum_iterations)
      : engine_(engine), pooled_(pooled), maximum_iterations_(maximum_iterations) {}

  void consider(const LindstromBatesState& start) {
    LindstromBatesOutcome outcome = run_from(engine_, start, maximum_iterations_);
    outcome.converged = outcome.converged && outcome.log_likelihood > pooled_ - kSameLikelihood;
    if (is_better(outcome, best_)) best_ = std::move(outcome);
  }

  /// From the first-order start, then from spreads of the random effects from wide to narrow, the
  /// narrow ones again with patience. A narrow start keeps groups that are far from the pooled fit
  /// from running into mirror images of their curves in the first step.
  void try_all_starts() {
    constexpr int kImpatient = 6;
    constexpr int kPatient = 100;
    engine_.set_patience(kImpatient);
    consider(engine_.first_order_start());
    if (best_.converged) return;
    for (const double spread : {1.0, 0.1, 0.01, 0.001}) consider(engine_.start(spread));
    if (best_.converged) return;
    engine_.set_patience(kPatient);
    for (const double spread : {0.1, 0.01}) consider(engine_.start(spread));
  }

  const LindstromBatesOutcome& best() const { return best_; }

 private:
  LindstromBates& engine_;
  double pooled_;
  int maximum_iterations_;
  LindstromBatesOutcome best_;
};

}  // namespace

LindstromBatesOutcome search_lindstrom_bates(const NonlinearModel& model,
                                             const VectorXd& start,
                                             LindstromBates& engine,
                                             int maximum_iterations) {
  const double pooled = pooled_log_likelihood(model, start);
  Search search(engine, pooled, maximum_iterations);
  if (engine.has_variance_function()) {
    engine.hold_variance(true);
    Search constant(engine, pooled, maximum_iterations);
    constant.try_all_starts();
    engine.hold_variance(false);
    search.consider(engine.first_order_start());
    if (constant.best().is_valid) {
      search.consider(engine.with_free_variance(constant.best().state));
    }
    if (search.best().converged) return search.best();
  }
  search.try_all_starts();
  return search.best();
}

std::string why_no_step(const NonlinearModel& model, const VectorXd& start) {
  NonlinearModel::Workspace workspace;
  VectorXd mean;
  MatrixXd jacobian;
  model.evaluate(start, mean, &jacobian, workspace);
  for (Index j = 0; j < jacobian.cols(); ++j) jacobian.col(j).normalize();
  const Eigen::ColPivHouseholderQR<MatrixXd> solver(jacobian);
  if (jacobian.allFinite() && solver.rank() < jacobian.cols()) {
    const Index last = solver.colsPermutation().indices()[jacobian.cols() - 1];
    return fmt::format(
        "Not converged: the data cannot tell {} apart from the other coefficients. Drop it, or "
        "what "
        "it depends on.",
        model.coefficient_names()[static_cast<std::size_t>(last)]);
  }
  return "Not converged: the first penalised least-squares step found no finite point. Try fewer "
         "random effects, or a model that the pooled data fit better.";
}

}  // namespace silvafit::fit
