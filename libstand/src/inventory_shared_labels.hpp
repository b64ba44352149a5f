// SPDX-License-Identifier: MIT
// Plots that bear one label in several stands.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <unordered_map>

namespace silvafit::stand {

/// Notices labels of plots that come under several values of a column of stands.
class SharedPlotLabels {
 public:
  void add(std::string_view plot, std::string_view stand);
  /// What to say of them; empty if there are none.
  /// \param column  that the stands are in
  std::string note(const std::string& column) const;

 private:
  std::unordered_map<std::string, std::string> stand_of_plot_{};  ///< where it came first
  std::map<std::string, std::string> other_stand_{};              ///< of plots that came again
  std::string last_plot_{};
  std::string last_stand_{};
};

}  // namespace silvafit::stand
