// SPDX-License-Identifier: MIT
// Plots with the same label in several stands.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

namespace silvafit::stand {

/// Finds labels of plots that occur in several stands.
class SharedPlotLabels {
 public:
  void add(std::string_view plot, std::string_view stand);
  /// The plots so far do not occur again; they are counted and removed from memory.
  void finish_plots();
  /// A note on these plots; empty if there are none.
  /// \param column  that the stands are in
  std::string note(const std::string& column) const;
  struct Example {
    std::string label{};
    std::string first{};  ///< first stand with the label
    std::string other{};  ///< the next one
  };
  std::optional<Example> first() const;
  /// The note if the labels are places, and their "stands" the plots of a visit each.
  std::string note_on_visits() const;

 private:
  struct Shared {
    std::string first{};  ///< first stand with the label
    std::string other{};  ///< the next one
  };

  std::unordered_map<std::string, std::string> stand_of_plot_{};  ///< first stand of each label
  std::map<std::string, Shared> shared_{};  ///< labels of several stands: after finish_plots() one
  std::size_t forgotten_ = 0;               ///< number of labels that were removed
  std::string last_plot_{};
  std::string last_stand_{};
};

}  // namespace silvafit::stand
