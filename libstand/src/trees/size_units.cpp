// SPDX-License-Identifier: MIT
#include "silvafit/stand/size_units.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string_view>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/median.hpp"
#include "silvafit/data/missing_codes.hpp"
#include "silvafit/stand/tree_columns.hpp"

namespace silvafit::stand {
namespace {

constexpr double kHeightOfStandMeters = 130.0;  // the tallest tree known is 116 m
constexpr double kDbhOfStandCentimeters = 250.0;
constexpr double kCrownOfStandMeters = 25.0;
constexpr double kStoutestStand = 20.0;  // h/dbh, both in the same unit
constexpr double kSlenderestStand = 200.0;
constexpr double kUsualSlenderness = 80.0;
constexpr double kThin = 0.9;  // cm

struct Unit {
  std::string_view name{};        ///< empty: cm for dbh, m for others
  std::string_view conversion{};  ///< what --columns appends
  double factor = 1.0;
};
constexpr Unit kRight{};
constexpr Unit kFeet{"feet", "*0.3048", 0.3048};
constexpr Unit kDecimeters{"decimeters", "/10", 0.1};
constexpr Unit kCentimeters{"centimeters", "/100", 0.01};
constexpr Unit kMillimeters{"millimeters", "/1000", 0.001};
constexpr Unit kDbhInches{"inches", "*2.54", 2.54};
constexpr Unit kDbhMillimeters{"millimeters", "/10", 0.1};
constexpr Unit kDbhDecimeters{"decimeters", "*10", 10.0};
constexpr Unit kDbhMeters{"meters", "*100", 100.0};
// Known tables are converted from inches and feet; a copy of one may be in our units already.
constexpr Unit kDbhConverted{"centimeters already", "*1", 1.0 / 2.54};
constexpr Unit kConverted{"meters already", "*1", 1.0 / 0.3048};
// So are those whose circumferences are in meters.
constexpr Unit kDbhFromMeters{"centimeters already", "/100", 0.01};

/// Units in which people measure dbh and height together.
struct UnitPair {
  Unit dbh{};
  Unit h{};
};
constexpr std::array<UnitPair, 14> kPairs{{{kDbhConverted, kConverted},
                                           {kDbhFromMeters, kRight},
                                           {kRight, kFeet},
                                           {kRight, kDecimeters},
                                           {kRight, kCentimeters},
                                           {kRight, kMillimeters},
                                           {kDbhInches, kFeet},
                                           {kDbhInches, kRight},
                                           {kDbhMillimeters, kRight},
                                           {kDbhMillimeters, kDecimeters},
                                           {kDbhMillimeters, kCentimeters},
                                           {kDbhMillimeters, kMillimeters},
                                           {kDbhMeters, kRight},
                                           {kDbhDecimeters, kRight}}};

/// An expression without the brackets around it.
std::string_view unbracketed(std::string_view text) {
  const bool is_bracketed = text.starts_with('(') && text.ends_with(')');
  return is_bracketed ? text.substr(1, text.size() - 2) : text;
}

/// The median of the positive, finite values; 0 if there are none.
double positive_median(std::span<const double> values) {
  std::vector<double> positive;
  std::ranges::copy_if(
      values, std::back_inserter(positive), [](double v) { return v > 0.0 && std::isfinite(v); });
  return positive.empty() ? 0.0 : median(std::move(positive));
}

/// Medians of a stand; 0 where unknown.
struct Medians {
  double dbh_cm = 0.0;
  double h_m = 0.0;
  double slenderness = 0.0;  ///< of the trees' ratios h/dbh, both in the same unit
  std::size_t trees = 0;     ///< that have both

  /// The height at which a stem of the median dbh buckles.
  double highest_m() const {
    constexpr double kMcMahon = 95.0;
    constexpr double kPalms = 1.25;
    return kPalms * kMcMahon * std::pow(dbh_cm / 100.0, 2.0 / 3.0);
  }
  bool buckles() const { return dbh_cm > 0.0 && h_m > highest_m(); }

  Medians in(const UnitPair& units) const {
    return {.dbh_cm = dbh_cm * units.dbh.factor,
            .h_m = h_m * units.h.factor,
            .slenderness = slenderness * units.h.factor / units.dbh.factor};
  }
  bool is_plausible() const {
    constexpr double kLowestMeters = 1.3;
    if (h_m > 0.0 && (h_m < kLowestMeters || h_m > kHeightOfStandMeters)) return false;
    if (dbh_cm > kDbhOfStandCentimeters || buckles()) return false;
    return slenderness == 0.0 || (slenderness >= kStoutestStand && slenderness <= kSlenderestStand);
  }
  /// How far a stand is from a usual one, in logarithms.
  double oddness() const {
    return slenderness == 0.0 ? 0.0 : std::abs(std::log(slenderness / kUsualSlenderness));
  }
};

class Judge {
 public:
  Judge(const std::vector<SizeColumn>& columns, const std::string& file);
  void check() const;
  /// Of whole tables: a species, or a layer of the stand, may be unlike these.
  void check_exchange() const;
  bool is_usual() const {
    return medians_.slenderness >= kLowestUsualSlenderness &&
           medians_.slenderness <= kHighestUsualSlenderness;
  }
  bool is_sapling() const { return medians_.dbh_cm > 0.0 && medians_.dbh_cm < kThin; }
  std::span<const double> values(std::string_view name) const;

 private:
  const SizeColumn* column(std::string_view name) const;
  bool is_dbh_wrong() const;
  bool is_h_wrong() const;
  /// "if h is in feet, use `columns=h=h*0.3048`", for each change of units.
  std::string advice(const UnitPair& units) const;
  std::vector<std::string> advice_on_trees() const;
  std::vector<std::string> advice_on_length(const SizeColumn& length, double most) const;
  [[noreturn]] void refuse(const SizeColumn& wrong, const std::vector<std::string>& advice) const;
  void check_length(std::string_view name, double most) const;

  const std::vector<SizeColumn>& columns_;
  const std::string& file_;
  Medians medians_{};
};

Judge::Judge(const std::vector<SizeColumn>& columns, const std::string& file)
    : columns_(columns), file_(file) {
  const std::span<const double> dbh = values("dbh");
  const std::span<const double> h = values("h");
  std::vector<double> ratios;
  for (std::size_t i = 0; i < std::min(dbh.size(), h.size()); ++i) {
    ratios.push_back(100.0 * h[i] / dbh[i]);
  }
  medians_ = {.dbh_cm = positive_median(dbh),
              .h_m = positive_median(h),
              .slenderness = positive_median(ratios),
              .trees = static_cast<std::size_t>(
                  std::ranges::count_if(ratios, [](double ratio) { return ratio > 0.0; }))};
}

const SizeColumn* Judge::column(std::string_view name) const {
  const auto found = std::ranges::find(columns_, name, &SizeColumn::name);
  return found == columns_.end() ? nullptr : &*found;
}

std::span<const double> Judge::values(std::string_view name) const {
  const SizeColumn* const found = column(name);
  return found == nullptr ? std::span<const double>{} : found->values;
}

bool Judge::is_dbh_wrong() const {
  constexpr double kThick = 60.0;
  constexpr double kStoutest = 12.0;
  constexpr std::size_t kEnough = 10;  // a few trees may all be odd ones
  constexpr double kSlenderest = 600.0;
  const auto& [dbh, h, slenderness, trees] = medians_;
  const bool is_stout =
      slenderness > 0.0 && slenderness < kStoutest && (dbh > kThick || trees >= kEnough);
  // Giants are tall, too: known heights decide.
  const bool has_heights = h > 0.0 && h < kHeightOfStandMeters;
  const bool is_too_thick = has_heights ? is_stout : dbh > kDbhOfStandCentimeters;
  const bool is_too_thin =
      dbh > 0.0 && dbh < kThin && (h == 0.0 || (has_heights && slenderness > kSlenderest));
  return is_too_thick || is_too_thin;
}

bool Judge::is_h_wrong() const {
  // The stems of saplings are much thicker at their base than at breast height.
  constexpr double kTall = 10.0;
  return medians_.h_m > kHeightOfStandMeters || (medians_.h_m > kTall && medians_.buckles());
}

std::string Judge::advice(const UnitPair& units) const {
  std::vector<std::string> conditions;
  std::vector<std::string> conversions;
  const auto add = [&](std::string_view name, const Unit& unit) {
    if (unit.name.empty()) return;
    conditions.push_back(fmt::format("{} is in {}", name, unit.name));
    std::string_view source = column(name)->source;
    if (unit.conversion == kConverted.conversion) {
      source = unbracketed(source).substr(0, unbracketed(source).rfind('*'));
    }
    conversions.push_back(fmt::format("{}={}{}", name, source, unit.conversion));
  };
  add("h", units.h);
  add("dbh", units.dbh);
  return fmt::format(
      "if {}, use `columns={}`", fmt::join(conditions, " and "), fmt::join(conversions, ","));
}

/// The units that make plausible stands, the most usual stand first.
std::vector<std::string> Judge::advice_on_trees() const {
  constexpr std::size_t kMost = 3;
  const auto is_converted = [this](std::string_view name, std::string_view conversion) {
    const SizeColumn* const found = column(name);
    return found != nullptr && !conversion.empty() &&
           unbracketed(found->source).ends_with(conversion);
  };
  const bool are_converted =
      is_converted("dbh", kDbhInches.conversion) && is_converted("h", kFeet.conversion);
  const auto is_possible = [&](const UnitPair& units) {
    if (units.h.name == kConverted.name && !are_converted) return false;
    const bool is_from_meters =
        column("dbh") != nullptr && column("dbh")->source.find("*100") != std::string::npos;
    if (units.dbh.conversion == kDbhFromMeters.conversion && !is_from_meters) return false;
    // What is converted already is in another unit than that.
    if (is_converted("dbh", units.dbh.conversion) || is_converted("h", units.h.conversion)) {
      return false;
    }
    return (units.h.name.empty() || medians_.h_m > 0.0) &&
           (units.dbh.name.empty() || medians_.dbh_cm > 0.0);
  };
  std::vector<UnitPair> fitting;
  std::ranges::copy_if(kPairs, std::back_inserter(fitting), [&](const UnitPair& units) {
    return is_possible(units) && medians_.in(units).is_plausible();
  });
  std::ranges::stable_sort(
      fitting, {}, [this](const UnitPair& units) { return medians_.in(units).oddness(); });
  if (fitting.size() > kMost) fitting.resize(kMost);
  std::vector<std::string> texts;
  for (const UnitPair& units : fitting) texts.push_back(advice(units));
  if (texts.empty()) {
    texts.emplace_back("no usual units explain it: check that the columns are these measures");
  }
  return texts;
}

std::vector<std::string> Judge::advice_on_length(const SizeColumn& length, double most) const {
  constexpr double kLeastMeters = 0.5;
  const double median = positive_median(length.values);
  std::vector<std::string> texts;
  for (const Unit& unit : {kFeet, kDecimeters, kCentimeters, kMillimeters}) {
    const double meters = median * unit.factor;
    if (meters < kLeastMeters || meters > most) continue;
    texts.push_back(fmt::format("if {0} is in {1}, use `columns={0}={2}{3}`",
                                length.name,
                                unit.name,
                                length.source,
                                unit.conversion));
  }
  return texts;
}

void Judge::refuse(const SizeColumn& wrong, const std::vector<std::string>& advice) const {
  const bool is_dbh = wrong.name == "dbh";
  const bool bends = wrong.name == "h" && medians_.h_m <= kHeightOfStandMeters;
  const bool is_pair = is_dbh && medians_.slenderness > 0.0;
  const std::string reason =
      bends
          ? fmt::format("higher than stems of the median dbh {:.4g} cm can stand", medians_.dbh_cm)
      : is_pair ? fmt::format("which no stand of trees has with the median height {:.4g} m by {}",
                              medians_.h_m,
                              column("h")->source)
                : "which no stand of trees has";
  throw InputError(
      fmt::format("{} has the median {:.4g} {}, {}; {}; if it is correct, use `trust_units=true`",
                  wrong.source,
                  positive_median(wrong.values),
                  is_dbh ? "cm" : "m",
                  reason,
                  fmt::join(advice, "; ")),
      {.file = file_, .column = std::string(wrong.name)});
}

void Judge::check_length(std::string_view name, double most) const {
  const SizeColumn* const length = column(name);
  if (length == nullptr || positive_median(length->values) <= most) return;
  refuse(*length, advice_on_length(*length, most));
}

/// Heights grow with a power of dbh below 1 (2/3 in McMahon 1973), so that they vary less.
/// Exchanged columns must also be nearer to a usual stand.
void Judge::check_exchange() const {
  Medians exchanged = medians_;
  exchanged.slenderness = 1e4 / medians_.slenderness;
  if (!(exchanged.oddness() < medians_.oddness())) return;
  constexpr std::size_t kEnough = 30;
  constexpr double kSteep = 1.3;
  constexpr double kRelated = 0.6;
  const std::span<const double> dbh = values("dbh");
  const std::span<const double> h = values("h");
  std::vector<double> log_dbh;
  std::vector<double> log_h;
  for (std::size_t i = 0; i < std::min(dbh.size(), h.size()); ++i) {
    if (!(dbh[i] > 0.0 && h[i] > 0.0) || std::isinf(dbh[i]) || std::isinf(h[i])) continue;
    log_dbh.push_back(std::log(dbh[i]));
    log_h.push_back(std::log(h[i]));
  }
  if (log_h.size() < kEnough) return;
  const auto n = static_cast<Eigen::Index>(log_h.size());
  Eigen::ArrayXd x = Eigen::Map<const Eigen::ArrayXd>(log_dbh.data(), n);
  Eigen::ArrayXd y = Eigen::Map<const Eigen::ArrayXd>(log_h.data(), n);
  x -= x.mean();
  y -= y.mean();
  const double spread_x = x.matrix().norm();
  const double spread_y = y.matrix().norm();
  if (spread_y < kSteep * spread_x || (x * y).sum() < kRelated * spread_x * spread_y) return;
  throw InputError(fmt::format("h varies {:.2g} times as much as dbh between trees, but heights of "
                               "trees vary less than diameters; if the columns are exchanged, use "
                               "`columns=dbh={},h={}`; if not, use `trust_units=true`",
                               spread_y / spread_x,
                               column("h")->source,
                               column("dbh")->source),
                   {.file = file_, .column = "dbh, h"});
}

void Judge::check() const {
  if (is_h_wrong()) refuse(*column("h"), advice_on_trees());
  check_length("hcb", kHeightOfStandMeters);
  if (is_dbh_wrong()) refuse(*column("dbh"), advice_on_trees());
  check_length("cw", kCrownOfStandMeters);
  for (const std::string_view radius : {"cr_e", "cr_w", "cr_s", "cr_n"}) {
    check_length(radius, kCrownOfStandMeters / 2.0);
  }
}

}  // namespace

/// What is wrong with the sizes of a species, if those of another are usual; empty if nothing is.
/// Shrubs and saplings may be much thinner than other species.
std::string species_in_other_units(const data::TextColumn& species,
                                   const std::vector<SizeColumn>& columns,
                                   const std::string& file) {
  constexpr std::size_t kFewestTrees = 5;
  std::vector<std::vector<std::size_t>> rows(species.levels().size());
  for (std::size_t row = 0; row < species.size(); ++row) {
    if (!species.is_missing(row)) rows[species.code(row)].push_back(row);
  }
  std::string first;
  bool has_others = false;
  for (std::size_t code = 0; code < rows.size(); ++code) {
    if (rows[code].size() < kFewestTrees) continue;
    std::vector<std::vector<double>> values(columns.size());
    std::vector<SizeColumn> own = columns;
    for (std::size_t k = 0; k < columns.size(); ++k) {
      for (const std::size_t row : rows[code]) values[k].push_back(columns[k].values[row]);
      own[k].values = values[k];
    }
    const Judge judge(own, file);
    if (judge.is_sapling()) continue;
    try {
      judge.check();
      has_others = has_others || judge.is_usual();
    } catch (const InputError& error) {
      if (!first.empty()) continue;
      first = fmt::format(
          "the file mixes units: of species {}, unlike others, {}; correct the file; if the values "
          "are correct, use `trust_units=true`",
          species.levels()[code],
          error.message().substr(0, error.message().find(';')));
    }
  }
  return has_others ? first : std::string();
}

namespace {

/// "if it is in mm, use `columns=dbh=dbh/10`; " for the first decimal unit in which no value is too
/// large and the median is one of trees; empty if there is none.
std::string advice_on_largest(const SizeColumn& column, double most) {
  constexpr std::array<std::pair<double, std::string_view>, 3> kOfMeters{
      {{10.0, "dm"}, {100.0, "cm"}, {1000.0, "mm"}}};
  constexpr double kLeast = 1.0;
  const bool is_cm = tree_column(column.name)->unit == "cm";
  double largest = 0.0;
  for (const double value : column.values) {
    if (std::isfinite(value)) largest = std::max(largest, value);
  }
  for (const auto& [divisor, unit] : kOfMeters) {
    if (is_cm && unit != "dm") break;
    if (largest / divisor > most || positive_median(column.values) / divisor < kLeast) continue;
    return fmt::format("if it is in {}, use `columns={}={}/{}`; ",
                       is_cm ? "mm" : unit,
                       column.name,
                       column.source,
                       divisor);
  }
  return {};
}

/// Refuses sizes that no tree has; infinite ones have errors of their own.
void check_largest(const std::vector<SizeColumn>& columns, const PlaceOfRow& place_of) {
  for (const SizeColumn& column : columns) {
    const TreeColumn* const known = tree_column(column.name);
    if (known == nullptr || known->range.largest == 0.0) continue;
    const auto is_too_large = [known](double value) {
      return value > known->range.largest && std::isfinite(value);
    };
    const auto first = std::ranges::find_if(column.values, is_too_large);
    if (first == column.values.end()) continue;
    Place place = place_of(static_cast<std::size_t>(first - column.values.begin()));
    place.column = column.name;
    throw InputError(
        fmt::format("{} {} is more than any tree has ({} {}), in {} of {} rows; {}correct or "
                    "convert the values; if they are right, use `trust_units=true`",
                    data::shortest(*first),
                    known->unit,
                    known->range.largest,
                    known->unit,
                    std::ranges::count_if(column.values, is_too_large),
                    column.values.size(),
                    advice_on_largest(column, known->range.largest)),
        place);
  }
}

}  // namespace

void check_units_of_trees(const data::TextColumn& plot,
                          const data::TextColumn& species,
                          const std::vector<SizeColumn>& columns,
                          const std::string& file,
                          const PlaceOfRow& place_of) {
  // First, because a code would be the largest tree.
  for (const SizeColumn& column : columns) {
    data::refuse_possible_code(column.values, {.file = file, .column = std::string(column.name)});
  }
  const Judge judge(columns, file);
  TreeSizes trees{.plot = plot, .species = species.size() > 0 ? &species : nullptr};
  if (plot.size() > 0) {
    trees.dbh_cm = judge.values("dbh");
    trees.h_m = judge.values("h");
  }
  // Before others, because messages about whole columns would be wrong for a part of the plots.
  const std::string mixed = describe_mixed_units(find_mixed_units(trees));
  if (!mixed.empty()) throw InputError(mixed, {.file = file, .column = "dbh, h"});
  const std::string odd = species_in_other_units(species, columns, file);
  if (!odd.empty()) throw InputError(odd, {.file = file, .column = "species"});
  judge.check();
  check_largest(columns, place_of);
  judge.check_exchange();
}

}  // namespace silvafit::stand
