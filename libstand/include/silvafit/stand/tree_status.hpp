// SPDX-License-Identifier: MIT
// Whether a tree is alive, from a status column in one of several languages.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit::stand {

enum class TreeStatus {
  kAlive,
  kDead,         ///< and standing
  kGone,         ///< cut, or a stump
  kFallen,       ///< down by itself, not cut
  kNotInSample,  ///< such as FIA's STATUSCD 0: the row is no measurement
};

/// The treatment of trees that are dead and standing by the status column.
enum class DeadTrees {
  kLeaveOut,   ///< they are skipped
  kNeighbors,  ///< they are used only as neighbors of living trees
  kInclude,    ///< they are used as living ones
};
constexpr std::array<std::string_view, 3> words_of(DeadTrees /*use*/) {
  return {"leave-out", "neighbors", "include"};
}

/// Values of a status column and their meaning by the user. Numbers are compared as numbers, other
/// values without regard to capitals.
struct StatusCodes {
  std::vector<std::string> alive{};
  std::vector<std::string> dead{};  ///< and standing
  std::vector<std::string> cut{};   ///< or fallen

  bool empty() const { return alive.empty() && dead.empty() && cut.empty(); }
};

struct KnownTable;

/// Reads the values of one column and counts them.
class StatusColumn {
 public:
  StatusColumn() = default;
  /// \param header  of the column: the meaning of 1 and 0 differs between `alive` and `dead`
  /// \param codes   they are preferred to usual words
  /// \param table   header of the table, whose codes may be documented (models/sources)
  /// \throws UsageError if a value has two meanings
  explicit StatusColumn(std::string header,
                        StatusCodes codes = {},
                        const std::vector<std::string>& table = {});

  /// Tells a value of the column before those of its part of the table are read, because some
  /// letters have a meaning by the others: D is dead, but dominant beside C, I and S.
  void learn(std::string_view value);

  /// An empty value and one that is not known mean alive; the latter are counted.
  TreeStatus read(std::string_view value);

  /// Numbers of dead standing trees, and of trees that no longer stand.
  std::size_t dead() const { return dead_; }
  std::size_t gone() const { return gone_; }
  std::size_t not_in_sample() const { return not_in_sample_; }
  /// \throws InputError if D was read as dead, or as a crown class, before values that contradict
  /// it
  void require_one_meaning(const std::string& file) const;
  const std::string& header() const { return header_; }
  /// "'B' (3), 'X' (1)": values that are not known; empty if there are none.
  std::string unknown_values() const;
  /// The part of a note on rows that are no measurements, on values that are not known or whose
  /// meaning is assumed, and on given codes that no row has; empty if there are none.
  std::string remarks() const;

 private:
  std::optional<TreeStatus> given_meaning(std::string_view value);
  std::optional<TreeStatus> meaning_of(std::string_view value) const;
  bool is_given(std::string_view value) const;
  bool is_by_letters() const;
  bool has_crown_classes() const;
  bool has_v_and_m() const;
  void count(std::string_view value, TreeStatus status);

  std::string header_{};
  std::optional<TreeStatus> if_true_{};  ///< of a column of answers, by its header
  const KnownTable* table_ = nullptr;
  std::map<std::string, std::optional<TreeStatus>, std::less<>> known_{};
  std::map<std::string, std::size_t> unknown_{};
  std::size_t dead_ = 0;
  std::size_t gone_ = 0;
  std::size_t not_in_sample_ = 0;
  std::size_t missing_ = 0;
  std::size_t empty_ = 0;
  std::size_t dominant_ = 0;      ///< rows of D that are alive
  std::size_t dead_letters_ = 0;  ///< rows of D that are not
  std::string first_alive_{};
  std::set<std::string, std::less<>> learned_{};
  std::set<std::string, std::less<>> letters_{};  ///< values of one or two letters, folded
  bool has_alive_ = false;  ///< a value is a word or code of living trees, other than V
  StatusCodes codes_{};
  std::set<std::string, std::less<>> seen_codes_{};
};

}  // namespace silvafit::stand
