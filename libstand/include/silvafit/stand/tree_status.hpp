// SPDX-License-Identifier: MIT
// Whether a tree is alive, from a status column in one of several languages.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace silvafit::stand {

enum class TreeStatus {
  kAlive,
  kDead,  ///< and standing
  kGone,  ///< cut, fallen or a stump
};

/// Reads the values of one column and counts them.
class StatusColumn {
 public:
  StatusColumn() = default;
  /// \param header  of the column: the meaning of 1 and 0 differs between `alive` and `dead`
  explicit StatusColumn(std::string header);

  /// An empty value and one that is not known mean alive; the latter are counted.
  TreeStatus read(std::string_view value);

  /// Numbers of dead standing trees, and of trees that no longer stand.
  std::size_t dead() const { return dead_; }
  std::size_t gone() const { return gone_; }
  const std::string& header() const { return header_; }
  /// "'B' (3), 'X' (1)": values that are not known; empty if there are none.
  std::string unknown_values() const;

 private:
  std::optional<TreeStatus> meaning_of(std::string_view value) const;

  std::string header_{};
  enum class Kind { kStatus, kAlive, kDead, kForestInventoryAnalysis } kind_ = Kind::kStatus;
  std::map<std::string, std::optional<TreeStatus>, std::less<>> known_{};
  std::map<std::string, std::size_t> unknown_{};
  std::size_t dead_ = 0;
  std::size_t gone_ = 0;
};

}  // namespace silvafit::stand
