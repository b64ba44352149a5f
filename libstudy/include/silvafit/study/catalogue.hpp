// SPDX-License-Identifier: MIT
// The catalogue of base models, read from models/base and checked.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/enum_words.hpp"
#include "silvafit/data/expression.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::study {

/// The sign of a parameter, if it is known before any fit.
enum class Sign { kAny, kPositive, kNegative };
constexpr std::array<std::string_view, 3> words_of(Sign /*sign*/) {
  return {"any", "positive", "negative"};
}

/// How a response changes with DBH for all parameters of the stated signs.
enum class Monotone { kUnknown, kIncreasing, kDecreasing };

/// A parameter of a base model.
struct BaseParameter {
  std::string name{};
  std::string meaning{};
  std::string unit{};  ///< "1" for a pure number
  Sign sign = Sign::kAny;
  /// Start value over min_, mean_, max_ and median_ of dbh, h and the response: `1/mean_dbh`.
  data::Expression start = data::Expression::constant(0.0);
};

/// A value of the model computed outside of the program.
struct ReferencePoint {
  std::map<std::string, double> arguments{};
  std::map<std::string, double> parameters{};
  double value = 0.0;
};

/// A case in which the model equals another one: `where` fixes parameters of this model, `with`
/// gives other model's parameters; both are expressions of this model's parameters.
struct Equivalence {
  std::string model{};
  std::map<std::string, data::Expression> where{};
  std::map<std::string, data::Expression> with{};
};

/// A condition on the parameters for a plausible curve, and the error if it does not hold.
struct SensibleCondition {
  /// 1 or 0, over the parameters and `top_dbh`, 1.2 times the largest DBH [cm]: `a > 0`.
  data::Expression condition = data::Expression::constant(1.0);
  std::string otherwise{};  ///< part of a sentence: "the curve has a pole"
};

/// One candidate equation for height (h), height to crown base (hcb) or crown width (cw).
struct BaseModel {
  std::string id{};    ///< "M4"
  std::string name{};  ///< "Meyer"
  std::string response{};
  std::string formula{};  ///< "h ~ 1.3 + a*(1 - exp(-b*dbh))"
  /// The right side of the formula.
  data::Expression mean = data::Expression::constant(0.0);
  std::vector<BaseParameter> parameters{};
  /// The data columns that the mean uses: dbh, and h for hcb.
  std::vector<std::string> covariates{};
  Monotone monotone = Monotone::kUnknown;
  /// Limits of the response as DBH goes to 0 and to infinity, for sensible parameters: expressions
  /// of the parameters and, for hcb, of h. The second is empty if there is none.
  data::Expression at_zero = data::Expression::constant(0.0);
  std::optional<data::Expression> at_infinity{};
  std::vector<SensibleCondition> sensible{};  ///< all must hold
  /// Conditions on the covariates, 1 or 0, all of which must hold.
  std::vector<data::Expression> domain{};
  std::vector<Equivalence> equals{};
  std::vector<ReferencePoint> reference_points{};
  /// Covariates outside the domain, for tests.
  std::vector<std::map<std::string, double>> invalid{};
  std::string notes{};
  std::vector<std::string> source{};
  std::filesystem::path file{};

  std::vector<std::string> parameter_names() const;
  /// The response of one tree.
  /// \throws UsageError if a name is missing
  double value(const std::map<std::string, double>& arguments,
               const std::map<std::string, double>& parameters) const;
  /// The error of the first sensible condition that these parameters do not satisfy; empty if they
  /// satisfy all.
  /// \param top_dbh_cm  1.2 times the largest DBH
  std::string violated_condition(std::map<std::string, double> parameters, double top_dbh_cm) const;
};

/// All base models of a folder `models`.
class Catalogue {
 public:
  /// Reads every file of `models/base`, sorted by the number in the id.
  /// \throws InputError that names the file and the key, if an entry cannot be used
  static Catalogue load(const std::filesystem::path& models_directory);

  const std::vector<BaseModel>& models() const { return models_; }
  /// \throws UsageError that lists the available models if there is no such model
  const BaseModel& find(std::string_view id) const;
  /// The candidates for a response, in the order of the catalogue.
  std::vector<const BaseModel*> candidates(std::string_view response) const;

 private:
  std::vector<BaseModel> models_;
};

/// Start values of a model's parameters for the rows of a table, in the order of `parameters`.
/// Rows with missing values in dbh, h or the response are excluded from the summaries.
/// \throws UsageError if a column that a start rule needs is missing or holds no number
std::vector<double> start_values(const BaseModel& model, const data::Table& table);

}  // namespace silvafit::study
