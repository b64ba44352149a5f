// SPDX-License-Identifier: MIT
#include "likelihood/linearization.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <memory>

#include "conditional_modes/effect_layout.hpp"
#include "conditional_modes/random_places.hpp"
#include "model/model_groups.hpp"
#include "silvafit/base/parallel.hpp"
#include "silvafit/data/row_sums.hpp"

namespace silvafit::fit {
namespace {

using data::Expression;

// A block's columns, some twenty of 8 bytes a row, stay in a cache of 256 KiB.
constexpr Index kBlockRows = 512;
// Rows per task of a thread, so many that the overhead of a task is small.
constexpr Index kChunkRows = 4096;
// The second-order series of exp(-2x) has an error of a tenth at this typical x; if g hardly
// changes, a larger range has no benefit.
constexpr double kTypicalChange = 0.4;
constexpr double kLongestChange = 1.0;

/// (p) the effects of a group on the columns of X before scaling.
VectorXd mixed_effects(const LinearizationPoint& point,
                       const std::vector<Index>& columns,
                       Index group) {
  VectorXd result = point.effects.col(group);
  if (point.mixing.size() == 0) return result;
  const MatrixXd mixing = point.mixing(columns, columns);
  const VectorXd own = result(columns);
  const VectorXd mixed = mixing.partialPivLu().solve(own);
  result(columns) = mixed;
  return result;
}

}  // namespace

Linearizer::Linearizer(const NonlinearModel& model, const VarianceModel& variance)
    : model_(model), variance_(variance), random_({.terms = model.random_coefficients()}) {
  for (Index c = 0; c <= model.cluster_count(); ++c) {
    random_.cluster_begin.push_back(model.cluster_begin(c));
  }
  random_.of_groups = model.groups().of_cells;
  if (model.crossed() != nullptr) random_.crossed = std::make_shared<const EffectLayout>(model);
  for (auto columns = random_.terms.rbegin(); columns != random_.terms.rend(); ++columns) {
    for (const Index column : *columns) {
      if (std::ranges::find(effect_columns_, column) == effect_columns_.end()) {
        effect_columns_.push_back(column);
      }
    }
  }
  make_segments();
  make_parameters();
  make_terms();
  make_programs();
}

bool Linearizer::is_curved() const {
  return variance_.correlated() != nullptr ||
         !std::ranges::all_of(quantity_pairs_, &QuantityPair::is_linear);
}

void Linearizer::make_segments() {
  Index in_block = 0;
  blocks_.push_back(0);
  for (Index group = 0; group < model_.group_count(); ++group) {
    const Index end = model_.group_begin(group + 1);
    for (Index begin = model_.group_begin(group); begin < end; begin += kBlockRows) {
      const Index stop = std::min(end, begin + kBlockRows);
      if (in_block > 0 && in_block + (stop - begin) > kBlockRows) {
        blocks_.push_back(segments_.size());
        in_block = 0;
      }
      segments_.push_back({.group = group,
                           .begin = begin,
                           .end = stop,
                           .is_first = begin == model_.group_begin(group),
                           .is_last = stop == end});
      in_block += stop - begin;
    }
  }
  blocks_.push_back(segments_.size());
  chunks_.push_back(0);
  Index rows = 0;
  for (std::size_t block = 0; block + 1 < blocks_.size(); ++block) {
    rows += segments_[blocks_[block + 1] - 1].end - segments_[blocks_[block]].begin;
    if (rows < kChunkRows && block + 2 < blocks_.size()) continue;
    chunks_.push_back(block + 1);
    rows = 0;
  }
}

void Linearizer::make_parameters() {
  const ParameterDesign& design = model_.design();
  for (Index k = 0; k < std::ssize(model_.specification().parameters); ++k) {
    const bool is_random = std::ranges::any_of(design.coefficients_of(k), [&](Index j) {
      return std::ranges::find(effect_columns_, j) != effect_columns_.end();
    });
    is_scalar_.push_back(!is_random && !design.has_covariates(k));
  }
}

void Linearizer::make_programs() {
  const ModelSpecification& specification = model_.specification();
  const Expression& mean = specification.formula.right;
  std::vector<Expression> outputs{mean};
  std::vector<data::Program::Input> inputs;
  for (std::size_t k = 0; k < is_scalar_.size(); ++k) {
    const std::string& name = specification.parameters[k].name;
    inputs.push_back({.name = name, .is_scalar = is_scalar_[k]});
    outputs.push_back(mean.derivative(name));
  }
  for (const std::string& name : model_.variables()) inputs.push_back({.name = name});
  const auto& quantities = variance_.quantities();
  const bool is_constant = variance_.log_scale().is_zero();
  if (!is_constant) {
    for (const VarianceModel::Quantity& quantity : quantities) {
      inputs.push_back({.name = quantity.name, .is_scalar = quantity.strata < 0});
    }
    const Expression logarithm =
        variance_.log_scale().substitute(VarianceModel::fitted_name(), mean);
    outputs.push_back(logarithm);
    outputs.push_back(Expression::parse("exp(-2*a)").substitute("a", logarithm));
    programs_[0] = data::Program(outputs, inputs);
    for (const VarianceModel::Quantity& quantity : quantities) {
      outputs.push_back(logarithm.derivative(quantity.name));
    }
    for (const QuantityPair& pair : quantity_pairs_) {
      if (pair.is_linear) continue;
      outputs.push_back(logarithm.derivative(quantities[pair.first].name)
                            .derivative(quantities[pair.second].name));
    }
  }
  programs_[1] = data::Program(outputs, inputs);
  if (is_constant) programs_[0] = programs_[1];

  output_count_ = outputs.size();
}

void Linearizer::prepare(Scratch& scratch) const {
  const Index rows = std::min(kBlockRows, model_.observations());
  scratch.parameter_values.resize(rows, static_cast<Index>(is_scalar_.size()));
  scratch.quantity_values.resize(rows, static_cast<Index>(variance_.quantities().size()));
  scratch.outputs.resize(rows, static_cast<Index>(output_count_));
  scratch.products.resize(rows, model_.column_count());
  scratch.residual.resize(rows);
  scratch.term_weight.resize(rows);
  scratch.columns.resize(static_cast<std::size_t>(model_.column_count()) + 1);
  scratch.group_products.resize(scratch.columns.size() * scratch.columns.size());
}

void Linearizer::fill_parameters(const LinearizationPoint& point,
                                 std::size_t first,
                                 std::size_t last,
                                 Scratch& scratch) const {
  const Index block_begin = segments_[first].begin;
  for (Index k = 0; k < scratch.parameter_values.cols(); ++k) {
    double* const column = scratch.parameter_values.col(k).data();
    if (is_scalar_[static_cast<std::size_t>(k)]) {
      model_.design().fill(
          k, block_begin, 1, [&point](Index j) { return point.coefficients[j]; }, column);
      continue;
    }
    for (std::size_t s = first; s < last; ++s) {
      const Segment& segment = segments_[s];
      const auto value = [&](Index j) {
        return point.coefficients[j] + point.effects(j, segment.group);
      };
      model_.design().fill(k,
                           segment.begin,
                           segment.end - segment.begin,
                           value,
                           column + (segment.begin - block_begin));
    }
  }
}

void Linearizer::fill_quantities(const LinearizationPoint& point,
                                 Index begin,
                                 Index rows,
                                 Scratch& scratch) const {
  const auto& quantities = variance_.quantities();
  for (std::size_t k = 0; k < quantities.size(); ++k) {
    const VarianceModel::Quantity& quantity = quantities[k];
    auto column = scratch.quantity_values.col(static_cast<Index>(k));
    const NonlinearModel::Strata* const strata = strata_of(k);
    if (strata == nullptr) {
      column[0] = point.variance[quantity.first];
      continue;
    }
    const Index skipped = quantity.has_reference ? 1 : 0;
    for (Index i = 0; i < rows; ++i) {
      const Index stratum = strata->of_rows[static_cast<std::size_t>(begin + i)] - skipped;
      column[i] = stratum < 0 ? 0.0 : point.variance[quantity.first + stratum];
    }
  }
}

void Linearizer::evaluate_block(const Pass& pass,
                                std::size_t first,
                                std::size_t last,
                                Scratch& scratch) const {
  const Index begin = segments_[first].begin;
  const Index rows = segments_[last - 1].end - begin;
  fill_parameters(pass.point, first, last, scratch);
  fill_quantities(pass.point, begin, rows, scratch);
  std::vector<const double*> inputs;
  for (Index k = 0; k < scratch.parameter_values.cols(); ++k) {
    inputs.push_back(scratch.parameter_values.col(k).data());
  }
  for (Index k = 0; k < model_.variable_values().cols(); ++k) {
    inputs.push_back(model_.variable_values().col(k).data() + begin);
  }
  for (Index k = 0; k < scratch.quantity_values.cols(); ++k) {
    inputs.push_back(scratch.quantity_values.col(k).data());
  }
  const data::Program& program = programs_[pass.expand ? 1 : 0];
  std::vector<double*> outputs;
  for (std::size_t k = 0; k < program.output_count(); ++k) {
    outputs.push_back(scratch.outputs.col(static_cast<Index>(k)).data());
  }
  program.evaluate(inputs, static_cast<std::size_t>(rows), outputs, scratch.workspace);
  pass.result.mean.segment(begin, rows) = scratch.outputs.col(0).head(rows);
  scratch.residual.head(rows) =
      model_.response().segment(begin, rows) - scratch.outputs.col(0).head(rows);
  const auto parameters = static_cast<Index>(is_scalar_.size());
  if (pass.result.weight.size() > 0) {
    pass.result.weight.segment(begin, rows) =
        scratch.outputs.col(parameters + 2).head(rows).array();
  }
  const ParameterDesign& design = model_.design();
  for (Index j = 0; j < model_.column_count(); ++j) {
    if (design.multiplier(j) == nullptr) continue;
    const double* const by_parameter = scratch.outputs.col(1 + design.parameter_of(j)).data();
    design.differentiate(j, begin, rows, by_parameter, scratch.products.col(j).data());
  }
  if (pass.point.mixing.size() > 0) mix(pass.point.mixing, rows, scratch);
}

const double* Linearizer::slope_column(Index coefficient, const Scratch& scratch) const {
  const ParameterDesign& design = model_.design();
  if (design.multiplier(coefficient) != nullptr) return scratch.products.col(coefficient).data();
  return scratch.outputs.col(1 + design.parameter_of(coefficient)).data();
}

void Linearizer::mix(const MatrixXd& mixing, Index rows, Scratch& scratch) const {
  scratch.mixed.resize(scratch.products.rows(), mixing.cols());
  for (Index j = 0; j < mixing.cols(); ++j) {
    auto column = scratch.mixed.col(j).head(rows);
    column = Eigen::Map<const VectorXd>(slope_column(j, scratch), rows);
    for (Index i = 0; i < mixing.rows(); ++i) {
      if (i == j || mixing(i, j) == 0.0) continue;
      column += mixing(i, j) * Eigen::Map<const VectorXd>(slope_column(i, scratch), rows);
    }
  }
}

void Linearizer::add_products(const double* weight, Index rows, Scratch& scratch, double* target) {
  std::vector<double>& products = scratch.group_products;
  data::weighted_products(scratch.columns, weight, static_cast<std::size_t>(rows), products.data());
  for (std::size_t k = 0; k < products.size(); ++k) target[k] += products[k];
}

void Linearizer::add_segment(const Pass& pass,
                             const Segment& segment,
                             Index block_begin,
                             Scratch& scratch,
                             double* products,
                             double& squares_before,
                             ChunkSums& sums) const {
  const Index offset = segment.begin - block_begin;
  const Index rows = segment.end - segment.begin;
  const auto count = static_cast<std::size_t>(rows);
  for (Index j = 0; j < model_.column_count(); ++j) {
    const double* const column =
        pass.point.mixing.size() > 0 ? scratch.mixed.col(j).data() : slope_column(j, scratch);
    scratch.columns[static_cast<std::size_t>(j)] = column + offset;
  }
  const double* const residual = scratch.residual.data() + offset;
  scratch.columns.back() = residual;
  const bool has_weight = pass.result.weight.size() > 0;
  if (variance_.correlated() != nullptr) {
    keep_rows(pass, segment, offset, scratch);
    if (has_weight) {
      const auto logarithm = static_cast<Index>(is_scalar_.size()) + 1;
      sums.sum_log[0] += data::sum(scratch.outputs.col(logarithm).data() + offset, count);
    }
    return;
  }
  const double* const weight = has_weight ? pass.result.weight.data() + segment.begin : nullptr;
  add_products(weight, rows, scratch, products);
  if (pass.before != nullptr && pass.before->weight.size() > 0) {
    squares_before +=
        data::weighted_dot(pass.before->weight.data() + segment.begin, residual, residual, count);
  }
  if (!has_weight) return;
  const auto parameters = static_cast<Index>(is_scalar_.size());
  sums.sum_log[0] += data::sum(scratch.outputs.col(parameters + 1).data() + offset, count);
  if (pass.expand) add_terms(pass, segment, offset, scratch, products, sums);
}

void Linearizer::finish_group(const Pass& pass, Index group, double* products) const {
  const GroupMoments& moments = pass.result.model.moments;
  const Index w = moments.width();
  const Index p = w - 1;
  pass.result.squares[group] = products[p * w + p];
  const VectorXd effects = mixed_effects(pass.point, effect_columns_, group);
  for (Index term = 0; term < moments.terms(); ++term, products += w * w) {
    for (Index a = 0; a < p; ++a) {
      for (Index c = 0; c < w; ++c) {
        products[a * w + c] *= pass.point.units[a];
        products[c * w + a] *= pass.point.units[a];
      }
    }
    // The working response w = r + Z b: column and row p get multiples of the others.
    for (const Index j : effect_columns_) {
      const double share = effects[j] / pass.point.units[j];
      for (Index a = 0; a < w; ++a) products[p * w + a] += share * products[j * w + a];
    }
    for (const Index j : effect_columns_) {
      const double share = effects[j] / pass.point.units[j];
      for (Index a = 0; a < w; ++a) products[a * w + p] += share * products[a * w + j];
    }
  }
}

void Linearizer::close_group(const Pass& pass, Index group, ChunkSums& sums) const {
  GroupMoments& moments = pass.result.model.moments;
  finish_group(pass, group, sums.open.data());
  if (group < pass.point.first_group || group >= pass.point.last_group) return;
  moments.keep(group, sums.open.data());
  if (moments.has_all_rows()) return;
  const Index w = moments.width();
  sums.totals += Eigen::Map<const MatrixXd>(sums.open.data(), w * w, moments.terms());
}

void Linearizer::center(const VectorXd& log_squares, Linearization& result) const {
  GroupMoments& moments = result.model.moments;
  const auto n = static_cast<double>(model_.observations());
  const VectorXd mean = moments.sum_log().segment(1, moments.parameters()) / n;
  moments.set_center(mean);
  result.longest_change.resize(moments.parameters());
  for (std::size_t k = 0; k < variance_.quantities().size(); ++k) {
    const VarianceModel::Quantity& quantity = variance_.quantities()[k];
    for (Index i = quantity.first; i < quantity.first + quantity.count; ++i) {
      const double square = log_squares[static_cast<Index>(k)] / n - mean[i] * mean[i];
      const double typical = std::sqrt(std::max(0.0, square));
      const bool is_exponent = quantity.kind == VarianceQuantity::kDelta && typical > 0.0;
      result.longest_change[i] = is_exponent ? kTypicalChange / typical
                                             : std::min(kLongestChange, kTypicalChange / typical);
    }
  }
}

void Linearizer::linearize_chunk(const Pass& pass,
                                 std::size_t chunk,
                                 Scratch& scratch,
                                 ChunkSums& sums) const {
  if (scratch.columns.empty()) prepare(scratch);
  GroupMoments& moments = pass.result.model.moments;
  sums.sum_log.setZero(moments.terms());
  sums.log_squares.setZero(static_cast<Index>(variance_.quantities().size()));
  const Segment& begin = segments_[blocks_[chunks_[chunk]]];
  const Index squared = moments.width() * moments.width();
  const auto size = static_cast<std::size_t>(moments.terms() * squared);
  if (!begin.is_first) sums.carried.assign(size, 0.0);
  if (!moments.has_all_rows()) sums.totals.setZero(squared, moments.terms());
  for (std::size_t block = chunks_[chunk]; block < chunks_[chunk + 1]; ++block) {
    const std::size_t first = blocks_[block];
    const std::size_t last = blocks_[block + 1];
    const bool is_needed = segments_[last - 1].group >= pass.point.first_group &&
                           segments_[first].group < pass.point.last_group;
    if (!is_needed) continue;
    evaluate_block(pass, first, last, scratch);
    for (std::size_t s = first; s < last; ++s) {
      const Segment& segment = segments_[s];
      const bool is_carried = !begin.is_first && segment.group == begin.group;
      if (segment.is_first) sums.open.assign(size, 0.0);
      add_segment(pass,
                  segment,
                  segments_[first].begin,
                  scratch,
                  is_carried ? sums.carried.data() : sums.open.data(),
                  is_carried ? sums.carried_before : pass.result.squares_before[segment.group],
                  sums);
      if (!segment.is_last || is_carried || variance_.correlated() != nullptr) continue;
      close_group(pass, segment.group, sums);
      sums.open.clear();
    }
  }
}

void Linearizer::add_carried(const Pass& pass, std::vector<ChunkSums>& chunks) const {
  for (std::size_t chunk = 1; chunk < chunks.size(); ++chunk) {
    ChunkSums& sums = chunks[chunk];
    if (sums.carried.empty() || variance_.correlated() != nullptr) continue;
    const Index group = segments_[blocks_[chunks_[chunk]]].group;
    ChunkSums& before = chunks[chunk - 1];
    before.open.resize(sums.carried.size());
    for (std::size_t k = 0; k < sums.carried.size(); ++k) before.open[k] += sums.carried[k];
    pass.result.squares_before[group] += sums.carried_before;
    const bool ends_here =
        model_.group_begin(group + 1) <= segments_[blocks_[chunks_[chunk + 1]] - 1].end;
    if (ends_here) close_group(pass, group, before);
    if (!ends_here) sums.open = std::move(before.open);
  }
}

bool Linearizer::linearize(const LinearizationPoint& point,
                           bool expand,
                           const Linearization* before,
                           Linearization& result) {
  model_.check_stop();
  const bool varies = !variance_.log_scale().is_zero();
  expand = expand && variance_.parameter_count() > 0;
  const Index width = model_.column_count() + 1;
  result.model.random = random_;
  result.model.observations = model_.observations();
  result.model.random_only = model_.column_count() - model_.coefficient_count();
  result.model.threads = model_.threads();
  using Pairs = decltype(pairs_);
  const bool has_series = expand && variance_.correlated() == nullptr;
  std::vector<Index> rows;
  if (random_.crossed) rows = RandomPlaces(random_.terms).all;
  result.model.moments = GroupMoments(width,
                                      model_.group_count(),
                                      expand ? variance_.parameter_count() : 0,
                                      has_series ? pairs_ : Pairs{},
                                      std::move(rows));
  result.mean.resize(model_.observations());
  result.weight.resize(varies ? model_.observations() : 0);
  result.squares.setZero(model_.group_count());
  result.squares_before.setZero(model_.group_count());
  result.variance = point.variance;
  scratch_.resize(worker_count(model_.threads()));
  if (variance_.correlated() != nullptr) {
    kept_rows_.resize(model_.observations(), width);
    if (expand) kept_slopes_.resize(model_.observations(), std::ssize(variance_.quantities()));
  }
  const Pass pass{.point = point, .expand = expand, .before = before, .result = result};
  std::vector<ChunkSums> chunks(chunks_.size() - 1);
  parallel_for(chunks.size(), model_.threads(), [&](std::size_t chunk, std::size_t worker) {
    linearize_chunk(pass, chunk, scratch_[worker], chunks[chunk]);
  });
  add_carried(pass, chunks);
  VectorXd log_squares = VectorXd::Zero(static_cast<Index>(variance_.quantities().size()));
  for (const ChunkSums& sums : chunks) {
    result.model.moments.sum_log() += sums.sum_log;
    log_squares += sums.log_squares;
    if (sums.totals.size() > 0) result.model.moments.add_totals(sums.totals);
  }
  if (variance_.correlated() != nullptr) return add_correlated(pass);
  if (before != nullptr && before->weight.size() == 0) result.squares_before = result.squares;
  if (expand) center(log_squares, result);
  return result.squares.allFinite() && result.model.moments.all_finite();
}

}  // namespace silvafit::fit
