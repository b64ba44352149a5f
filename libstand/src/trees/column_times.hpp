// SPDX-License-Identifier: MIT
// A column of times in which the day of dates is found from all of them.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/base/error.hpp"
#include "trees/measurement_time.hpp"

namespace silvafit::stand {

/// Reads dates such as 5/6/2019 by the day_place() of their column.
class ColumnTimes {
 public:
  /// \param times  of the column; may be distinct ones only
  explicit ColumnTimes(const std::vector<std::string>& times) : place_(day_place(times)) {}

  /// A time as with_year_first().
  /// \param where  for the message
  /// \throws InputError if the place of the day is unknown, and the plot has two such dates in one
  ///   year, whose order depends on it
  std::string read(std::string_view plot, std::string_view time, const Place& where);
  /// How such dates were read; empty if there were none.
  std::string note() const;

 private:
  DayPlace place_;
  std::string first_{};  ///< the first such date
  std::map<std::pair<std::string, std::string>, std::string> date_in_year_{};  ///< of each plot
};

/// The years of a time by years_of().
/// \throws InputError if it is not a year or date
double required_years_of(const std::string& time, const Place& where);

}  // namespace silvafit::stand
