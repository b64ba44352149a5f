// SPDX-License-Identifier: MIT
#include "prediction/prediction_intervals.hpp"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "prediction/nonlinear_directions.hpp"
#include "prediction/prediction_freedom.hpp"
#include "prediction/prediction_rules.hpp"
#include "prediction/residual_spread.hpp"
#include "prediction/row_mean.hpp"
#include "prediction/student_quantiles.hpp"
#include "prediction/value_quantiles.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/parallel.hpp"

namespace silvafit::fit {
namespace {

// Rows per block, which limits the memory.
constexpr std::size_t kChunk = 4096;

/// What the parts of the table share.
struct Setting {
  const FittedModel& fit;
  const CoefficientSets& sets;
  const PredictionOptions& options;
  const MatrixXd& marginal_gradients;
  Freedom freedom;
  std::optional<StudentQuantiles> t_quantiles{};  ///< if there are intervals
};

/// Some rows of the table.
class Chunk {
 public:
  Chunk(const Setting& all,
        const data::Table& table,
        std::size_t begin,
        std::size_t end,
        Prediction& result)
      : all_(all),
        begin_(static_cast<Index>(begin)),
        rows_(static_cast<Index>(end - begin)),
        part_(selected(table, begin, end)),
        mean_(all.fit.specification, part_, uncertain_names(all.options)),
        result_(result) {
    set_of_row_.assign(all.sets.set_of_row.begin() + begin_,
                       all.sets.set_of_row.begin() + begin_ + rows_);
    arguments_ = mean_.arguments(all.sets.coefficients, set_of_row_);
    center_ = mean_.mean(arguments_);
    gradient_ = mean_.gradient(arguments_);
    residual_sd_ = residual_sd_if_known(all.fit, center_, part_);
    for (const UncertainColumn& column : all.options.uncertain) {
      if (!uses(column.name)) continue;
      uncertain_.push_back(&column);
    }
  }

  void run() {
    const VectorXd known = known_variance();
    store_errors(known, effect_variances());
    if (!all_.options.interval) return;
    if (all_.options.interval_kind == IntervalKind::kConfidence) {
      confidence();
    } else {
      prediction();
    }
  }

 private:
  static data::Table selected(const data::Table& table, std::size_t begin, std::size_t end) {
    std::vector<std::size_t> rows;
    for (std::size_t row = begin; row < end; ++row) rows.push_back(row);
    return table.select(rows);
  }
  static std::vector<std::string> uncertain_names(const PredictionOptions& options) {
    std::vector<std::string> names;
    for (const UncertainColumn& column : options.uncertain) names.push_back(column.name);
    return names;
  }
  bool uses(const std::string& column) const {
    const std::vector<std::string> names = all_.fit.specification.predictors();
    return std::ranges::find(names, column) != names.end();
  }
  /// Whether the effects of each term are estimated for a row.
  const std::vector<bool>& known_terms(Index row) const {
    return all_.sets.known[static_cast<std::size_t>(set_of_row_[static_cast<std::size_t>(row)])];
  }
  bool is_marginal(Index row) const {
    return all_.sets
        .is_marginal[static_cast<std::size_t>(set_of_row_[static_cast<std::size_t>(row)])];
  }

  /// (K + U x K + U) covariance of a row's arguments from one of all coefficients, and from the
  /// uncertain columns.
  MatrixXd spread(Index row, const Eigen::Ref<const MatrixXd>& covariance, bool of_tree) const {
    const Index size = mean_.argument_count();
    MatrixXd result = MatrixXd::Zero(size, size);
    const ParameterDesign& design = mean_.design();
    const Index p = design.coefficient_count();
    for (Index j = 0; j < p; ++j) {
      const double of_column = design.multiplier(j, row);
      if (of_column == 0.0) continue;
      for (Index i = 0; i < p; ++i) {
        result(design.parameter_of(i), design.parameter_of(j)) +=
            covariance(i, j) * design.multiplier(i, row) * of_column;
      }
    }
    for (std::size_t k = 0; k < uncertain_.size(); ++k) {
      const Index at = mean_.parameter_count() + static_cast<Index>(k);
      result(at, at) =
          (of_tree ? uncertain_[k]->tree_variance : uncertain_[k]->mean_variance)[begin_ + row];
    }
    return result;
  }
  Eigen::Map<const MatrixXd> known_covariance(Index row) const {
    const ParameterDesign& design = mean_.design();
    const Index p = design.coefficient_count();
    const Index set = set_of_row_[static_cast<std::size_t>(row)];
    return {all_.sets.covariances.col(set).data(), p, p};
  }

  /// (N) variance of the mean from what was estimated.
  VectorXd known_variance() const {
    VectorXd result(rows_);
    VectorXd slope;
    for (Index row = 0; row < rows_; ++row) {
      if (is_marginal(row)) {
        slope = all_.marginal_gradients.row(begin_ + row);
      } else {
        set_coefficient_slope(row, slope);
      }
      result[row] = variance_along(slope, known_covariance(row)) + uncertain_variance(row, false);
    }
    return result;
  }

  /// (N x terms) variances of the mean over the random effects of each term.
  MatrixXd effect_variances() const {
    MatrixXd result = MatrixXd::Zero(rows_, std::ssize(all_.fit.random));
    VectorXd slope;
    for (std::size_t t = 0; t < all_.fit.random.size(); ++t) {
      const EstimatedEffects& term = all_.fit.random[t];
      const MatrixXd covariance = among_coefficients(all_.fit, term.names, term.covariance);
      for (Index row = 0; row < rows_ && !covariance.isZero(0.0); ++row) {
        set_coefficient_slope(row, slope);
        result(row, static_cast<Index>(t)) = variance_along(slope, covariance);
      }
    }
    return result;
  }

  /// s' V s without temporary memory.
  static double variance_along(const VectorXd& slope, const Eigen::Ref<const MatrixXd>& variance) {
    double sum = 0.0;
    for (Index j = 0; j < slope.size(); ++j) sum += slope[j] * variance.col(j).dot(slope);
    return sum;
  }

  double uncertain_variance(Index row, bool of_tree) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < uncertain_.size(); ++k) {
      const double slope = gradient_(row, mean_.parameter_count() + static_cast<Index>(k));
      sum += slope * slope *
             (of_tree ? uncertain_[k]->tree_variance : uncertain_[k]->mean_variance)[begin_ + row];
    }
    return sum;
  }

  /// The variances of terms whose effects are estimated, or are not; zero of the others.
  static SmallVector part_of(SmallVector effects,
                             const std::vector<bool>& known,
                             bool are_estimated) {
    for (std::size_t t = 0; t < known.size(); ++t) {
      if (known[t] != are_estimated) effects[static_cast<Index>(t)] = 0.0;
    }
    return effects;
  }

  /// \param known    (N) variances of the error of estimates
  /// \param effects  (N x terms) of the mean over the random effects
  void store_errors(const VectorXd& known, const MatrixXd& effects) {
    const bool is_prediction = all_.options.interval_kind == IntervalKind::kPrediction;
    VectorXd slope;
    for (Index row = 0; row < rows_; ++row) {
      set_coefficient_slope(row, slope);
      const SmallVector of_open = part_of(effects.row(row), known_terms(row), false);
      const double of_residual = residual_sd_[row] * residual_sd_[row];
      const double more = uncertain_variance(row, true) - uncertain_variance(row, false);
      VarianceParts parts =
          known_parts(row, slope, known[row] - uncertain_variance(row, false), effects.row(row));
      if (is_prediction) {
        parts.of_terms += of_open;
        parts.total += of_open.sum() + of_residual;
      }
      const Index at = begin_ + row;
      result_.mean_error[at] = std::sqrt(known[row]);
      result_.prediction_error[at] = std::sqrt(known[row] + of_open.sum() + of_residual + more);
      result_.degrees_of_freedom[at] =
          std::isnan(parts.total) ? kNaN : all_.freedom.value(parts, slope);
    }
  }

  /// (p) derivatives of a row's mean by the coefficients.
  void set_coefficient_slope(Index row, VectorXd& slope) const {
    const ParameterDesign& design = mean_.design();
    slope.resize(design.coefficient_count());
    for (Index k = 0; k < slope.size(); ++k) {
      slope[k] = gradient_(row, design.parameter_of(k)) * design.multiplier(k, row);
    }
  }

  /// The part of the variance between groups in the conditional variance of estimated effects.
  ///
  /// In one dimension the conditional variance of the effects of a group or coarser group is
  /// v = psi s / (psi + s), with s the error variance of the effects estimated from its trees only.
  /// The part of psi is psi dv/dpsi = v^2 / psi.
  /// \param slope    (p) derivatives of the row's mean by the coefficients
  /// \param effects  (terms) variances of the mean over the random effects
  VarianceParts known_parts(Index row,
                            const VectorXd& slope,
                            double known,
                            const SmallVector& effects) const {
    VarianceParts parts{.total = known, .of_terms = SmallVector::Zero(effects.size())};
    if (!all_.fit.has_random_effects()) return parts;
    if (std::ranges::count(known_terms(row), true) == 0) {
      if (!is_marginal(row)) return all_.freedom.of_fixed(slope, known);
      return all_.freedom.of_fixed(VectorXd(all_.marginal_gradients.row(begin_ + row)), known);
    }
    const SmallVector estimated = part_of(effects, known_terms(row), true);
    const double whole = estimated.sum();
    if (!(whole > 0.0)) return parts;
    const double part = known * std::min(1.0, known / whole);
    parts.of_terms = part / whole * estimated;
    return parts;
  }

  double t_quantile(Index row) const {
    return all_.t_quantiles->at(result_.degrees_of_freedom[begin_ + row]);
  }

  /// The mean at the coefficients that are t standard errors away in the direction in which it
  /// changes most, on either side.
  struct Ends {
    VectorXd lower{};
    VectorXd upper{};
    /// Whether the mean is on its side of the prediction and near it: along a ridge of strongly
    /// correlated coefficients the direction may lead away from it, to values that say nothing
    /// about the prediction.
    std::vector<bool> is_near{};
  };

  /// \param least, most  distances from the prediction that are near, in those of a linear mean
  Ends ends(double least, double most) const {
    MatrixXd low = arguments_;
    MatrixXd high = arguments_;
    VectorXd margin = VectorXd::Zero(rows_);
    for (Index row = 0; row < rows_; ++row) {
      const VectorXd slope = gradient_.row(row);
      const VectorXd direction = spread(row, known_covariance(row), false) * slope;
      const double error = std::sqrt(slope.dot(direction));
      // If the error is unknown, the limits are unknown.
      if (error == 0.0) continue;
      const VectorXd step = t_quantile(row) / error * direction;
      low.row(row) -= step.transpose();
      high.row(row) += step.transpose();
      margin[row] = t_quantile(row) * error;
    }
    Ends result{.lower = mean_.mean(low), .upper = mean_.mean(high)};
    for (Index row = 0; row < rows_; ++row) {
      const auto is_like = [&](double distance) {
        return distance >= least * margin[row] && distance <= most * margin[row];
      };
      result.is_near.push_back(
          std::isnan(margin[row]) ||
          (is_like(center_[row] - result.lower[row]) && is_like(result.upper[row] - center_[row])));
    }
    return result;
  }

  /// Rows whose mean is a function of one linear combination of coefficients.
  std::vector<bool> have_one_combination() const {
    std::vector<MatrixXd> roots;
    for (Index row = 0; row < rows_; ++row) {
      const MatrixXd covariance = spread(row, known_covariance(row), false);
      const bool is_known = covariance.allFinite() && gradient_.row(row).allFinite();
      roots.push_back(is_known ? rotated_root(root_without_zeros(covariance), gradient_.row(row))
                               : MatrixXd::Zero(covariance.rows(), 0));
    }
    const VectorXd tolerance = kStraight * result_.mean_error.segment(begin_, rows_);
    return follow_one_combination(mean_, arguments_, roots, tolerance);
  }

  /// The prediction plus and minus t standard errors, however the coefficients are written: along a
  /// ridge of correlated coefficients the mean changes little between values far apart, and is no
  /// straight line. Of one linear combination of coefficients the mean has the limits of that
  /// combination, as in generalized linear models; they are possible values of the mean.
  void confidence() {
    const std::vector<bool> is_of_one = have_one_combination();
    const Ends moved = ends(0.0, kInfinity);
    for (Index row = 0; row < rows_; ++row) {
      const Index at = begin_ + row;
      const auto k = static_cast<std::size_t>(row);
      const double margin = t_quantile(row) * result_.mean_error[at];
      // A marginal mean is not a value of the curve at any coefficients.
      const bool is_curve = !is_marginal(row) && is_of_one[k] && moved.is_near[k] &&
                            std::isfinite(moved.lower[row] + moved.upper[row]);
      result_.lower[at] = is_curve ? moved.lower[row] : result_.value[at] - margin;
      result_.upper[at] = is_curve ? moved.upper[row] : result_.value[at] + margin;
    }
  }

  /// Limits by quadrature over the errors of the arguments.
  void prediction() {
    std::map<std::vector<bool>, MatrixXd> open;  // by the terms whose effects are estimated
    std::vector<std::size_t> known;
    std::vector<MatrixXd> roots;
    MatrixXd covariance;
    Index last_set = -1;
    // Without covariates in sub-models the rows of a set have one covariance.
    MatrixXd last_of;
    MatrixXd root;
    // Its points are farther away, in directions in which the mean hardly changes, too.
    const Ends moved = ends(0.8, 1.25);
    for (Index row = 0; row < rows_; ++row) {
      if (!moved.is_near[static_cast<std::size_t>(row)]) {
        const Index at = begin_ + row;
        const double margin = t_quantile(row) * result_.prediction_error[at];
        result_.lower[at] = result_.value[at] - margin;
        result_.upper[at] = result_.value[at] + margin;
        continue;
      }
      // Many consecutive rows are of the same group, or of the population.
      const Index set = set_of_row_[static_cast<std::size_t>(row)];
      if (set != last_set) {
        const auto [place, is_new] = open.try_emplace(known_terms(row));
        if (is_new) place->second = open_covariance(all_.fit, known_terms(row));
        covariance = known_covariance(row) + place->second;
        last_set = set;
      }
      const MatrixXd of = spread(row, covariance, true);
      if (!of.allFinite() || !std::isfinite(center_[row]) || !std::isfinite(residual_sd_[row])) {
        continue;
      }
      known.push_back(static_cast<std::size_t>(row));
      if (of.rows() != last_of.rows() || of != last_of) {
        root = root_without_zeros(of);
        last_of = of;
      }
      roots.push_back(rotated_root(root, gradient_.row(row)));
    }
    if (known.empty()) return;
    const data::Table table = part_.select(known);
    const std::vector<std::string> uncertain = uncertain_names(all_.options);
    const double tail = 0.5 - 0.5 * *all_.options.interval;
    const VectorXd errors = result_.prediction_error.segment(begin_, rows_);
    store_ends(known,
               value_quantiles({.fit = all_.fit,
                                .table = table,
                                .uncertain = uncertain,
                                .arguments = arguments_(known, Eigen::all),
                                .value = center_(known),
                                .gradient = gradient_(known, Eigen::all),
                                .error = errors(known),
                                .roots = std::move(roots)},
                               tail));
  }

  /// Quantiles of known variances are widened as those of one normal distribution would be.
  void store_ends(const std::vector<std::size_t>& rows, const MatrixXd& quantiles) {
    const boost::math::normal_distribution<double> normal;
    const double z = boost::math::quantile(normal, 0.5 + 0.5 * *all_.options.interval);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const auto row = static_cast<Index>(rows[k]);
      const double wider = t_quantile(row) / z;
      const auto end = [&](Index side) {
        return center_[row] + wider * (quantiles(static_cast<Index>(k), side) - center_[row]);
      };
      result_.lower[begin_ + row] = end(0);
      result_.upper[begin_ + row] = end(1);
    }
  }

  const Setting& all_;
  Index begin_;
  Index rows_;
  data::Table part_;
  RowMean mean_;
  Prediction& result_;
  std::vector<Index> set_of_row_;
  std::vector<const UncertainColumn*> uncertain_;
  MatrixXd arguments_;
  VectorXd center_;
  MatrixXd gradient_;
  VectorXd residual_sd_;
};

}  // namespace

void add_errors(const FittedModel& fit,
                const data::Table& table,
                const CoefficientSets& sets,
                const PredictionOptions& options,
                const MatrixXd& marginal_gradients,
                Prediction& values) {
  const Index n = values.value.size();
  values.mean_error.setConstant(n, kNaN);
  values.prediction_error.setConstant(n, kNaN);
  values.degrees_of_freedom.setConstant(n, kNaN);
  if (options.interval) {
    values.lower.setConstant(n, kNaN);
    values.upper.setConstant(n, kNaN);
  }
  Setting all{.fit = fit,
              .sets = sets,
              .options = options,
              .marginal_gradients = marginal_gradients,
              .freedom = Freedom(fit)};
  if (options.interval) all.t_quantiles.emplace(0.5 + 0.5 * *options.interval);
  const std::size_t chunks = (table.rows() + kChunk - 1) / kChunk;
  parallel_for(chunks, options.threads, [&](std::size_t k) {
    const std::size_t end = std::min(table.rows(), (k + 1) * kChunk);
    Chunk(all, table, k * kChunk, end, values).run();
  });
}

}  // namespace silvafit::fit
