// SPDX-License-Identifier: MIT
// Plots with the same label in several stands.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <unordered_map>

namespace silvafit::stand {

/// Notices labels of plots that come under several values of a column of stands.
class SharedPlotLabels {
 public:
  void add(std::string_view plot, std::string_view stand);
  /// The plots so far do not come again; they are counted and forgotten.
  void finish_plots();
  /// A note on these plots; empty if there are none.
  /// \param column  that the stands are in
  std::string note(const std::string& column) const;

 private:
  struct Shared {
    std::string first{};  ///< stand where the label came first
    std::string other{};  ///< the next one
  };

  std::unordered_map<std::string, std::string> stand_of_plot_{};  ///< where it came first
  std::map<std::string, Shared> shared_{};  ///< labels of several stands: after finish_plots() one
  std::size_t forgotten_ = 0;               ///< the others
  std::string last_plot_{};
  std::string last_stand_{};
};

}  // namespace silvafit::stand
