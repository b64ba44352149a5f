// SPDX-License-Identifier: MIT
#include "mixed_effects/confounded_variances.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "mixed_effects/effect_columns.hpp"
#include "model/symmetric_eigen.hpp"
#include "variance/variance_kind.hpp"
#include "verdict/thresholds.hpp"

namespace silvafit::fit {
namespace {

/// A direction of the covariance of the observations.
struct Component {
  std::optional<std::size_t> term{};  ///< none: of the residuals
  MatrixXd form{};                    ///< (q x q) change of T Psi T' of the term
  Index column = 0;                   ///< of the derivatives of the log residual standard deviation
};

/// A change of all variance components.
struct Direction {
  std::vector<MatrixXd> effects{};  ///< of T Psi T' of each term
  VectorXd residual{};  ///< (m + 1) of the internal variance parameters and the log of sigma

  double largest() const {
    double result = residual.cwiseAbs().maxCoeff();
    for (const MatrixXd& of : effects) result = std::max(result, of.cwiseAbs().maxCoeff());
    return result;
  }
};

class Components {
 public:
  Components(const NonlinearModel& model, const VarianceModel& variance, const VariancePoint& point)
      : model_(model), variance_(variance), point_(point) {
    MatrixXd weighted = weighted_jacobian();
    if (!whiten(weighted)) return;
    const Index m = variance.parameter_count();
    by_residual_ = MatrixXd::Ones(weighted.rows(), m + 1);
    if (m > 0) {
      by_residual_.leftCols(m) = variance.scale(point.fitted, point.variance, true).log_derivative;
    }
    const auto is_known = [](const MatrixXd& psi) { return psi.allFinite(); };
    is_finite_ = weighted.allFinite() && by_residual_.allFinite() &&
                 std::ranges::all_of(point.effects, is_known);
    if (!is_finite_) return;
    for (std::size_t t = 0; t < model.term_count(); ++t) {
      terms_.push_back(
          effect_columns(model, model.specification().random[t], point.effects[t], weighted));
      is_finite_ = is_finite_ && terms_.back().columns.allFinite();
    }
    if (const Index p = model.coefficient_count(); point.is_restricted && p > 0) {
      const Eigen::HouseholderQR<MatrixXd> qr(weighted.leftCols(p));
      mean_ = qr.householderQ() * MatrixXd::Identity(weighted.rows(), p);
    }
    add_components();
    products_ = gram();
  }

  bool is_finite() const { return is_finite_; }

  /// Variances and covariances of effects that depend on others.
  Index redundant_count() const {
    Index count = 0;
    for (const EffectColumns& term : terms_) {
      if (!term.effects->has_equal_variances()) count += term.free_covariances;
    }
    return count;
  }

  /// Directions in which the covariance of the observations does not change, except those in which
  /// Psi would not remain a covariance.
  std::vector<Direction> unidentified() const {
    std::vector<Index> known;
    for (Index k = 0; k < products_.rows(); ++k) {
      if (sizes_[k] > 0.0) known.push_back(k);
    }
    std::vector<Direction> result = without_effect();
    for (Direction& covariance : covariances_without_effect()) {
      result.push_back(std::move(covariance));
    }
    const Index without_effect_count = std::ssize(result);
    const VectorXd unit = sizes_(known).cwiseInverse();
    const MatrixXd scaled = unit.asDiagonal() * products_(known, known) * unit.asDiagonal();
    const SymmetricEigen of = symmetric_eigen(scaled);
    const Index count = (of.values.array() <= Thresholds::kDependent).count();
    if (count == 0) return result;
    const MatrixXd null = of.vectors.leftCols(count);
    const auto direction_of = [&](const VectorXd& change) {
      VectorXd whole = VectorXd::Zero(products_.rows());
      whole(known) = unit.cwiseProduct(change);
      return direction(whole);
    };
    std::vector<Direction> candidates;
    for (Index k = 0; k < count; ++k) candidates.push_back(direction_of(null.col(k)));
    // At a boundary, a move may be possible only from one component to another.
    for (const VectorXd& whole_covariance : whole_covariances()) {
      const VectorXd part = sizes_(known).cwiseProduct(whole_covariance(known));
      candidates.push_back(direction_of(null * (null.transpose() * part)));
    }
    for (const Direction& candidate : candidates) {
      if (std::ssize(result) < count + without_effect_count && keeps_covariance(candidate)) {
        result.push_back(candidate);
      }
    }
    return result;
  }

  /// Names of the standard deviations and correlations that move in one of the directions.
  std::vector<std::string> effect_names(const std::vector<Direction>& directions) const {
    std::vector<std::string> result;
    for (std::size_t t = 0; t < terms_.size(); ++t) add_effect_names(t, directions, result);
    return result;
  }

  /// The same for the variance function and sigma.
  void add_residual_names(const std::vector<Direction>& directions,
                          std::vector<std::string>& result) const {
    add_variance_names(directions, result);
    add_correlation_names(directions, result);
    const auto moves_sigma = [&](const Direction& of) {
      return sigma_change(of) > Thresholds::kUnmoved;
    };
    if (std::ranges::any_of(directions, moves_sigma)) result.emplace_back("sigma");
  }

 private:
  /// (N x p) the Jacobian of the mean in residual standard deviations, computed with only one
  /// matrix as long as the data.
  MatrixXd weighted_jacobian() const {
    MatrixXd jacobian = model_.curve_at(point_.coefficients).jacobian;
    for (Index j = 0; j < jacobian.cols(); ++j) {
      jacobian.col(j) = jacobian.col(j).cwiseProduct(point_.residual_sd.cwiseInverse());
    }
    return jacobian;
  }

  /// Makes rows independent; false if they cannot be tested: a correlation is singular, or the
  /// blocks are so large that their matrices take too long.
  bool whiten(MatrixXd& rows) {
    const CorrelatedRows* const correlated = variance_.correlated();
    if (correlated == nullptr) return true;
    constexpr Index kLargest = 1000;
    if (correlated->structure().scale().largest > kLargest) return false;
    factors_ = correlated->factors(variance_.correlation_part(point_.variance), 1);
    if (factors_.empty()) return false;
    correlated->change(factors_, rows, [](const CorrelationFactor& factor, MatrixXd& part) {
      factor.whiten(part);
    });
    return true;
  }

  /// (n x n) L^-1 dR L'^-1 of a block with R the covariance of its standardized residuals, for each
  /// parameter of the variance function, of the correlation, and log sigma.
  std::vector<MatrixXd> residual_forms(std::size_t block) const {
    const std::vector<Index>& rows = variance_.correlated()->blocks()[block].rows;
    const CorrelationFactor& factor = *factors_[block];
    const MatrixXd identity = MatrixXd::Identity(std::ssize(rows), std::ssize(rows));
    const Index scale_count = variance_.parameter_count() - variance_.correlation_count();
    std::vector<MatrixXd> result;
    for (Index j = 0; j < scale_count; ++j) {
      MatrixXd half = identity;
      factor.color(half);
      half = (by_residual_(rows, j).asDiagonal() * half).eval();
      factor.whiten(half);
      result.emplace_back(half + half.transpose());
    }
    const bool is_at_end = has_correlation_at_end();
    for (Index k = 0; k < variance_.correlation_count(); ++k) {
      const MatrixXd half = factor.slope(k, identity);
      result.emplace_back(is_at_end ? MatrixXd::Zero(half.rows(), half.cols())
                                    : MatrixXd(-half - half.transpose()));
    }
    result.emplace_back(2.0 * identity);
    return result;
  }

  /// Whether a process or a matrix is at the end of its range, where its other parameters may have
  /// one effect: a boundary, of which nothing can be removed.
  bool has_correlation_at_end() const {
    const Correlation::Kind kind = variance_.correlated()->structure().correlation().kind;
    if (kind != Correlation::Kind::kArma && kind != Correlation::Kind::kSymmetric) return false;
    // tanh(x/2) is 1 to within kDependence from here on.
    const double end = std::log(2.0 / Thresholds::kDependence);
    return variance_.correlation_part(point_.variance).cwiseAbs().maxCoeff() > end;
  }

  void add_components() {
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      for (MatrixXd& form : forms_of(terms_[t])) all_.push_back({t, std::move(form)});
    }
    for (Index k = 0; k < by_residual_.cols(); ++k) all_.push_back({.column = k});
  }

  /// Adds the contribution of some rows to the Gram matrix.
  class Sum {
   public:
    Sum(const Components& components, MatrixXd& total)
        : of_(components), total_(total), parts_(components.all_.size()) {}

    /// Products of components of two terms over the rows that are in a group of both.
    void add_terms(std::size_t coarse, std::size_t fine) {
      MatrixXd products;
      const std::vector<Meeting> all = of_.meetings(fine, coarse);
      for (std::size_t k = 0; k < all.size(); ++k) {
        const Index begin = of_.model_.group_begin(all[k].cell);
        const Index rows = of_.model_.group_begin(all[k].cell + 1) - begin;
        const MatrixXd own = of_.terms_[fine].columns.middleRows(begin, rows).transpose() *
                             of_.terms_[coarse].columns.middleRows(begin, rows);
        const bool is_new = k == 0 || !all[k].is_with(all[k - 1]);
        products = is_new ? own : MatrixXd(products + own);
        if (k + 1 < all.size() && all[k + 1].is_with(all[k])) continue;
        if (fine == coarse) {
          add_within(fine, products);
        } else {
          add_between(coarse, fine, products);
        }
      }
    }

    /// Products of all components with those of the residuals.
    void add_residual() {
      if (of_.variance_.correlated() != nullptr) return add_correlated_residual();
      const MatrixXd& by_residual = of_.by_residual_;
      for (std::size_t k = 0; k < parts_.size(); ++k) {
        const VectorXd diagonal = of_.diagonal(of_.all_[k]);
        for (std::size_t l = 0; l < parts_.size(); ++l) {
          const bool is_later = !of_.all_[k].term && l > k;
          if (of_.all_[l].term || is_later) continue;
          add(std::max(k, l),
              std::min(k, l),
              2.0 * diagonal.dot(by_residual.col(of_.all_[l].column)));
        }
      }
    }

   private:
    /// Products of components of a term over the rows of one of its groups.
    void add_within(std::size_t term, const MatrixXd& products) {
      for (std::size_t k = 0; k < parts_.size(); ++k) {
        if (of_.all_[k].term != term) continue;
        parts_[k] = of_.all_[k].form * products;
        for (std::size_t l = 0; l <= k; ++l) {
          if (of_.all_[l].term == term)
            add(k, l, parts_[k].cwiseProduct(parts_[l].transpose()).sum());
        }
      }
    }

    void add_between(std::size_t coarse, std::size_t fine, const MatrixXd& products) {
      for (std::size_t k = 0; k < parts_.size(); ++k) {
        if (of_.all_[k].term == coarse) parts_[k] = of_.all_[k].form * products.transpose();
        if (of_.all_[k].term != fine) continue;
        const MatrixXd part = of_.all_[k].form * products;
        for (std::size_t l = 0; l < k; ++l) {
          if (of_.all_[l].term == coarse) {
            add(k, l, part.cwiseProduct(parts_[l].transpose()).sum());
          }
        }
      }
    }

    /// The same where the matrices of the residuals have blocks.
    void add_correlated_residual() {
      for (std::size_t b = 0; b < of_.factors_.size(); ++b) {
        const std::vector<Index>& rows = of_.variance_.correlated()->blocks()[b].rows;
        const std::vector<MatrixXd> forms = of_.residual_forms(b);
        const std::size_t first = parts_.size() - forms.size();
        for (std::size_t l = 0; l < forms.size(); ++l) {
          for (std::size_t k = 0; k < l + first + 1; ++k) {
            if (k >= first) {
              add(first + l, k, forms[l].cwiseProduct(forms[k - first]).sum());
              continue;
            }
            const MatrixXd z = of_.terms_[*of_.all_[k].term].columns(rows, Eigen::all);
            add(first + l, k, of_.all_[k].form.cwiseProduct(z.transpose() * forms[l] * z).sum());
          }
        }
      }
    }

    void add(std::size_t k, std::size_t l, double value) {
      total_(static_cast<Index>(k), static_cast<Index>(l)) += value;
    }

    const Components& of_;
    MatrixXd& total_;  ///< lower triangle
    std::vector<MatrixXd> parts_;
  };

  /// A group of the model that is in a group of one term and in a group of another.
  struct Meeting {
    Index fine = 0;
    Index coarse = 0;
    Index cell = 0;

    bool is_with(const Meeting& other) const {
      return fine == other.fine && coarse == other.coarse;
    }
  };
  /// Those of two terms, sorted by the groups of both.
  std::vector<Meeting> meetings(std::size_t fine, std::size_t coarse) const {
    std::vector<Meeting> result;
    for (Index cell = 0; cell < model_.group_count(); ++cell) {
      result.push_back({model_.group_of(fine, cell), model_.group_of(coarse, cell), cell});
    }
    std::ranges::stable_sort(
        result, {}, [](const Meeting& of) { return std::pair(of.fine, of.coarse); });
    return result;
  }

  /// (N) the diagonal of a component's matrix.
  VectorXd diagonal(const Component& component) const {
    if (!component.term) return 2.0 * by_residual_.col(component.column);
    const MatrixXd& z = terms_[*component.term].columns;
    return (z * component.form).cwiseProduct(z).rowwise().sum();
  }

  /// (K x K) tr(R^-1 V_k R^-1 V_l); leaves the lengths of the matrices in sizes_.
  MatrixXd gram() {
    const auto count = static_cast<Index>(all_.size());
    MatrixXd total = MatrixXd::Zero(count, count);
    Sum sum(*this, total);
    sum.add_residual();
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      for (std::size_t coarse = 0; coarse <= t; ++coarse) sum.add_terms(coarse, t);
    }
    sizes_ = total.diagonal().cwiseSqrt();
    const double rounding = 1e-10 * std::sqrt(static_cast<double>(by_residual_.rows()));
    sizes_ = (sizes_.array() > rounding).select(sizes_, 0.0);
    if (mean_.size() > 0) take_mean_out(total);
    return total.selfadjointView<Eigen::Lower>();
  }

  /// From tr(AB) to tr(MAMB), with M = I - QQ' the projection on the complement of the
  /// coefficients: tr(AB) - 2 tr(Q'ABQ) + tr(Q'AQ Q'BQ).
  void take_mean_out(MatrixXd& total) const {
    std::vector<MatrixXd> images;
    std::vector<MatrixXd> inner_products;
    for (const Component& component : all_) {
      images.push_back(image(component));
      inner_products.push_back(mean_.transpose() * images.back());
    }
    for (std::size_t k = 0; k < all_.size(); ++k) {
      for (std::size_t l = 0; l <= k; ++l) {
        total(static_cast<Index>(k), static_cast<Index>(l)) +=
            inner_products[k].cwiseProduct(inner_products[l]).sum() -
            2.0 * images[k].cwiseProduct(images[l]).sum();
      }
    }
  }

  /// Calls with the first row and the rows of each of the model's groups, and its group of a term.
  template <class Call>
  void for_each_cell(std::size_t term, const Call& call) const {
    for (Index cell = 0; cell < model_.group_count(); ++cell) {
      const Index begin = model_.group_begin(cell);
      call(begin, model_.group_begin(cell + 1) - begin, model_.group_of(term, cell));
    }
  }

  /// (N x p) the product of a component's matrix and Q.
  MatrixXd image(const Component& component) const {
    if (!component.term && variance_.correlated() != nullptr) {
      MatrixXd result(mean_.rows(), mean_.cols());
      for (std::size_t b = 0; b < factors_.size(); ++b) {
        const std::vector<Index>& rows = variance_.correlated()->blocks()[b].rows;
        result(rows, Eigen::all) =
            residual_forms(b)[static_cast<std::size_t>(component.column)] * mean_(rows, Eigen::all);
      }
      return result;
    }
    if (!component.term) {
      return 2.0 * by_residual_.col(component.column).asDiagonal() * mean_;
    }
    const std::size_t term = *component.term;
    const MatrixXd& z = terms_[term].columns;
    MatrixXd result(mean_.rows(), mean_.cols());
    std::vector<MatrixXd> sums(static_cast<std::size_t>(model_.group_count(term)),
                               MatrixXd::Zero(z.cols(), mean_.cols()));
    for_each_cell(term, [&](Index begin, Index rows, Index group) {
      sums[static_cast<std::size_t>(group)] +=
          z.middleRows(begin, rows).transpose() * mean_.middleRows(begin, rows);
    });
    for_each_cell(term, [&](Index begin, Index rows, Index group) {
      result.middleRows(begin, rows) =
          z.middleRows(begin, rows) * (component.form * sums[static_cast<std::size_t>(group)]);
    });
    return result;
  }

  /// Parameters of the variance function without effect: powers and rates of a variable that is
  /// constant. (Constant-plus-power has such parameters at its bounds.) The same of a process.
  std::vector<Direction> without_effect() const {
    std::vector<Direction> result;
    for (const VarianceModel::Quantity& quantity : variance_.quantities()) {
      const auto& factors = model_.specification().variance.factors;
      if (kind_of(factors[quantity.factor]).has_constant()) continue;
      for (Index k = quantity.first; k < quantity.first + quantity.count; ++k) {
        const Index place = std::ssize(all_) - by_residual_.cols() + k;
        if (sizes_[place] == 0.0)
          result.push_back(direction(VectorXd::Unit(std::ssize(all_), place)));
      }
    }
    if (!is_process() || has_correlation_at_end()) return result;
    // Partial autocorrelations of lags that no group has.
    for (Index place = std::ssize(all_) - 1 - variance_.correlation_count();
         place < std::ssize(all_) - 1;
         ++place) {
      if (sizes_[place] == 0.0) {
        result.push_back(direction(VectorXd::Unit(std::ssize(all_), place)));
      }
    }
    return result;
  }

  bool is_process() const {
    return variance_.correlated() != nullptr &&
           variance_.correlated()->structure().correlation().kind == Correlation::Kind::kArma;
  }

  /// Covariances of effects that no group has both of.
  std::vector<Direction> covariances_without_effect() const {
    std::vector<Direction> result;
    for (std::size_t k = 0; k < all_.size(); ++k) {
      const auto at = static_cast<Index>(k);
      if (!all_[k].term || sizes_[at] > 0.0) continue;
      const EffectColumns& level = terms_[*all_[k].term];
      const MatrixXd product = level.columns.colwise().norm().asDiagonal() *
                               all_[k].form.cwiseAbs() *
                               level.columns.colwise().norm().asDiagonal();
      if (product.maxCoeff() == 0.0) continue;
      Direction one = direction(VectorXd::Unit(std::ssize(all_), at));
      if (keeps_covariance(one)) result.push_back(std::move(one));
    }
    return result;
  }

  Direction direction(const VectorXd& change) const {
    Direction result{.residual = VectorXd::Zero(by_residual_.cols())};
    for (const EffectColumns& term : terms_) {
      const Index q = term.triangle.rows();
      result.effects.emplace_back(MatrixXd::Zero(q, q));
    }
    for (std::size_t k = 0; k < all_.size(); ++k) {
      const double share = change[static_cast<Index>(k)];
      if (all_[k].term) {
        result.effects[*all_[k].term] += share * all_[k].form;
      } else {
        result.residual[all_[k].column] += share;
      }
    }
    const double largest = result.largest();
    if (largest > 0.0) {
      for (MatrixXd& of : result.effects) of /= largest;
      result.residual /= largest;
    }
    return result;
  }

  /// (K) each: the whole covariance of one of the terms, or of the residuals.
  std::vector<VectorXd> whole_covariances() const {
    std::vector<VectorXd> result(terms_.size() + 1, VectorXd::Zero(std::ssize(all_)));
    for (std::size_t k = 0; k < all_.size(); ++k) {
      const auto at = static_cast<Index>(k);
      const Component& component = all_[k];
      if (!component.term) {
        const bool is_sigma = component.column + 1 == by_residual_.cols();
        if (is_sigma) result.back()[at] = 0.5;
        continue;
      }
      // The nonzero entries of the forms are disjoint, so that this is the part of each.
      result[*component.term][at] =
          terms_[*component.term].covariance.cwiseProduct(component.form).sum() /
          component.form.squaredNorm();
    }
    return result;
  }

  /// Whether Psi remains a covariance for a step in the direction or against it.
  bool keeps_covariance(const Direction& of) const {
    if (of.largest() == 0.0) return false;
    const bool moves_residual = of.residual.cwiseAbs().maxCoeff() > Thresholds::kUnmoved;
    double size = moves_residual ? 1.0 : 0.0;
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      const bool moves = of.effects[t].cwiseAbs().maxCoeff() > Thresholds::kUnmoved;
      if (moves) size = std::max(size, terms_[t].covariance.trace());
    }
    const auto are_covariances = [&](double step) {
      constexpr double kRounding = 1e-10;
      for (std::size_t t = 0; t < terms_.size(); ++t) {
        const MatrixXd moved = terms_[t].covariance + step * of.effects[t];
        if (symmetric_eigen(moved).values[0] < -kRounding * size) return false;
      }
      return true;
    };
    for (const double share : {0.3, 0.1, 0.03, 0.01, 1e-3}) {
      for (const double step : {share * size, -share * size}) {
        if (size > 0.0 && are_covariances(step)) return true;
      }
    }
    return false;
  }

  void add_effect_names(std::size_t term,
                        const std::vector<Direction>& directions,
                        std::vector<std::string>& result) const {
    const EffectColumns& level = terms_[term];
    const MatrixXd& psi = point_.effects[term];
    const auto triangle = level.triangle.triangularView<Eigen::Upper>();
    std::vector<MatrixXd> changes;  // of Psi, relative to R
    for (const Direction& direction : directions) {
      const MatrixXd half = triangle.solve(direction.effects[term]);
      changes.emplace_back(level.size.asDiagonal() * triangle.solve(half.transpose()) *
                           level.size.asDiagonal());
    }
    const MatrixXd scaled = level.size.asDiagonal() * psi * level.size.asDiagonal();
    const auto is_redundant = [&level](Index i) {
      return level.redundant.cols() > 0 && !level.effects->has_equal_variances() &&
             level.redundant.row(i).cwiseAbs().maxCoeff() >
                 Thresholds::kUnmoved * level.redundant.cwiseAbs().maxCoeff();
    };
    const auto is_moved = [&](Index i, Index j) {
      if (is_redundant(i) && is_redundant(j)) return true;
      return std::ranges::any_of(changes, [&](const MatrixXd& change) {
        if (i == j) return std::abs(change(i, i)) > Thresholds::kUnmoved;
        const double product = std::sqrt(scaled(i, i) * scaled(j, j));
        if (!(product > 0.0)) return false;
        const double along =
            0.5 * scaled(i, j) * (change(i, i) / scaled(i, i) + change(j, j) / scaled(j, j));
        return std::abs(change(i, j) - along) > Thresholds::kUnmoved * product;
      });
    };
    const std::string group =
        terms_.size() < 2 ? std::string() : " | " + level.effects->group_name();
    const std::vector<std::string>& names = level.effects->coefficients;
    for (std::size_t k = 0; k < names.size(); ++k) {
      const auto at = static_cast<Index>(k);
      if (is_moved(at, at)) result.push_back(fmt::format("sd({}{})", names[k], group));
    }
    std::size_t begin = 0;
    for (const int size : level.effects->block_sizes()) {
      for (std::size_t i = begin; i < begin + static_cast<std::size_t>(size); ++i) {
        for (std::size_t j = i + 1; j < begin + static_cast<std::size_t>(size); ++j) {
          if (!is_moved(static_cast<Index>(i), static_cast<Index>(j))) continue;
          result.push_back(fmt::format("cor({}, {}{})", names[i], names[j], group));
        }
      }
      begin += static_cast<std::size_t>(size);
    }
  }

  void add_variance_names(const std::vector<Direction>& directions,
                          std::vector<std::string>& result) const {
    const std::vector<VarianceFactor>& factors = model_.specification().variance.factors;
    for (const VarianceModel::Quantity& quantity : variance_.quantities()) {
      const VarianceFactor& factor = factors[quantity.factor];
      std::string name = quantity.kind == VarianceQuantity::kDelta      ? "delta"
                         : quantity.kind == VarianceQuantity::kConstant ? "constant"
                                                                        : "ratio";
      if (factors.size() > 1) name += " of " + factor.text();
      for (Index k = 0; k < quantity.count; ++k) {
        const bool is_moved = std::ranges::any_of(directions, [&](const Direction& of) {
          return std::abs(of.residual[quantity.first + k]) > Thresholds::kUnmoved;
        });
        if (!is_moved) continue;
        const auto stratum = static_cast<std::size_t>(k + (quantity.has_reference ? 1 : 0));
        result.push_back(
            quantity.strata < 0
                ? name
                : fmt::format("{} ({})", name, model_.strata(factor.stratum).labels[stratum]));
      }
    }
  }

  void add_correlation_names(const std::vector<Direction>& directions,
                             std::vector<std::string>& result) const {
    if (variance_.correlation_count() == 0) return;
    const CorrelationStructure& structure = variance_.correlated()->structure();
    const VectorXd parameters = variance_.correlation_part(point_.variance);
    constexpr double kStep = 1e-4;
    for (Index k = 0; k < variance_.correlation_count(); ++k) {
      const bool is_moved = std::ranges::any_of(directions, [&](const Direction& of) {
        const VectorXd own =
            of.residual.segment(variance_.parameter_count() - variance_.correlation_count(),
                                variance_.correlation_count());
        if (own.cwiseAbs().maxCoeff() <= Thresholds::kUnmoved) return false;
        if (structure.is_separable()) return std::abs(own[k]) > Thresholds::kUnmoved;
        const VectorXd change = structure.natural(parameters + kStep * own) -
                                structure.natural(parameters - kStep * own);
        return std::abs(change[k]) > Thresholds::kUnmoved * kStep;
      });
      if (is_moved) result.push_back(structure.names()[static_cast<std::size_t>(k)]);
    }
  }

  /// Of the logarithm of the reported sigma.
  double sigma_change(const Direction& of) const {
    constexpr double kStep = 1e-4;
    const VectorXd parameters = of.residual.head(variance_.parameter_count());
    const double factor = std::log(variance_.sigma_factor(point_.variance + kStep * parameters) /
                                   variance_.sigma_factor(point_.variance - kStep * parameters)) /
                          (2.0 * kStep);
    const double internal = of.residual[of.residual.size() - 1];
    // At a bound of a variance function the factor is discontinuous.
    return std::isfinite(factor) ? std::abs(internal + factor) : std::abs(internal);
  }

  const NonlinearModel& model_;
  const VarianceModel& variance_;
  const VariancePoint& point_;
  bool is_finite_ = false;
  CorrelatedRows::Factors factors_;  ///< of correlated residuals
  std::vector<EffectColumns> terms_;
  MatrixXd by_residual_;  ///< (N x (m + 1)) derivatives of the log residual standard deviation
  MatrixXd mean_;         ///< (N x p) Q, for the restricted likelihood
  std::vector<Component> all_;
  MatrixXd products_;  ///< (K x K)
  VectorXd sizes_;     ///< (K) lengths of the matrices; 0 for zero matrices
};

}  // namespace

ConfoundedVariances confounded_variances(const NonlinearModel& model,
                                         const VarianceModel& variance,
                                         const VariancePoint& point) {
  const Components components(model, variance, point);
  if (!components.is_finite()) return {};
  const std::vector<Direction> directions = components.unidentified();
  ConfoundedVariances result{
      .names = components.effect_names(directions),
      .directions = static_cast<int>(std::ssize(directions) + components.redundant_count())};
  result.has_effects = !result.names.empty();
  components.add_residual_names(directions, result.names);
  return result;
}

}  // namespace silvafit::fit
