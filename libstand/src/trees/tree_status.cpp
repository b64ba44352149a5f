// SPDX-License-Identifier: MIT
#include "silvafit/stand/tree_status.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/base/words.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/expression.hpp"
#include "silvafit/data/table.hpp"
#include "trees/folded_text.hpp"
#include "trees/known_tables.hpp"
#include "trees/status_words.hpp"

namespace silvafit::stand {
namespace {

/// Different values that decide the meaning of letters; a column of letters has fewer.
constexpr std::size_t kMostLearned = 1000;

struct GivenCodes {
  const std::vector<std::string>* codes;
  TreeStatus meaning;
  const char* option;
};

std::array<GivenCodes, 3> lists_of(const StatusCodes& codes) {
  return {{{&codes.alive, TreeStatus::kAlive, "`alive_codes`"},
           {&codes.dead, TreeStatus::kDead, "`dead_codes`"},
           {&codes.cut, TreeStatus::kGone, "`cut_codes`"}}};
}

void check_codes(const StatusCodes& codes) {
  const auto lists = lists_of(codes);
  for (std::size_t i = 0; i < lists.size(); ++i) {
    for (const std::string& code : *lists[i].codes) {
      for (std::size_t k = i + 1; k < lists.size(); ++k) {
        const auto is_same = [&code](const std::string& other) {
          return is_same_code(code, other);
        };
        if (std::ranges::none_of(*lists[k].codes, is_same)) continue;
        throw UsageError(
            fmt::format("the status '{}' is in {} and {}", code, lists[i].option, lists[k].option),
            {.column = lists[k].option});
      }
    }
  }
}

/// A value as conditions have it.
std::string quoted_unless_number(const std::string& value) {
  double ignored = 0.0;
  return data::parse_number(value, ignored) ? value : '"' + value + '"';
}

}  // namespace

StatusColumn::StatusColumn(std::string header,
                           StatusCodes codes,
                           const std::vector<std::string>& table)
    : header_(std::move(header)),
      table_(known_status_table(header_, table)),
      codes_(std::move(codes)) {
  check_codes(codes_);
  if (const auto of_header = status_of_header(header_)) if_true_ = of_header->status;
}

void StatusColumn::learn(std::string_view value) {
  const bool is_full = learned_.size() == kMostLearned;
  if (value.empty() || is_full || learned_.contains(value)) return;
  learned_.emplace(value);
  std::string letters = folded_letters(value);
  constexpr std::size_t kLongestCode = 2;
  const bool is_alive = status_in(value, StatusText::kStatus) == TreeStatus::kAlive;
  has_alive_ = has_alive_ || (is_alive && letters != "v");
  if (!letters.empty() && letters.size() <= kLongestCode) letters_.insert(std::move(letters));
  // The same letter may have been read with another meaning.
  known_.clear();
}

bool StatusColumn::is_given(std::string_view value) const {
  return std::ranges::any_of(lists_of(codes_), [value](const GivenCodes& list) {
    return std::ranges::any_of(
        *list.codes, [value](const std::string& code) { return is_same_code(code, value); });
  });
}

/// Whether neither the header nor the user explains D.
bool StatusColumn::is_by_letters() const {
  return !if_true_ && table_ == nullptr && !is_given("D");
}

/// Dominant, codominant, intermediate and suppressed: D beside C, I or S, but no code of living
/// trees.
bool StatusColumn::has_crown_classes() const {
  const auto has = [this](const char* letter) { return letters_.contains(letter); };
  const bool has_classes = has("d") && (has("c") || has("i") || has("s"));
  return has_classes && !has_alive_ && !has("v") && is_by_letters();
}

/// Vivo and muerto, vivant and mort: M alone may be anything.
bool StatusColumn::has_v_and_m() const {
  const auto is_one = [](const std::string& letters) { return has_word("v m c t", letters); };
  return !has_alive_ && letters_.contains("v") && std::ranges::all_of(letters_, is_one);
}

std::optional<TreeStatus> StatusColumn::meaning_of(std::string_view value) const {
  const std::string word = folded_letters(value);
  const auto answer = if_true_ ? answer_in(value) : std::nullopt;
  if (answer) {
    const bool is_alive = *answer == (*if_true_ == TreeStatus::kAlive);
    return is_alive ? TreeStatus::kAlive : *answer ? *if_true_ : TreeStatus::kDead;
  }
  const std::optional<TreeStatus> named = status_in(value, StatusText::kStatus);
  // A tree that is "missing" was not found.
  const bool is_missing = data::is_missing_number(value) && named != TreeStatus::kGone;
  if (word.empty() || is_missing) return TreeStatus::kAlive;
  if (table_ != nullptr) {
    if (const auto known = known_status(*table_, value)) return known;
  }
  if (has_crown_classes() && has_word("d c i s", word)) return TreeStatus::kAlive;
  if (word == "m" && has_v_and_m()) return TreeStatus::kDead;
  return named;
}

std::optional<TreeStatus> StatusColumn::given_meaning(std::string_view value) {
  for (const GivenCodes& list : lists_of(codes_)) {
    for (const std::string& code : *list.codes) {
      if (!is_same_code(code, value)) continue;
      seen_codes_.insert(code);
      return list.meaning;
    }
  }
  return std::nullopt;
}

TreeStatus StatusColumn::read(std::string_view value) {
  auto known = known_.find(value);
  if (known == known_.end()) {
    learn(value);
    const std::optional<TreeStatus> given = given_meaning(value);
    known = known_.emplace(std::string(value), given ? given : meaning_of(value)).first;
  }
  if (!known->second) {
    ++unknown_[known->first];
    return TreeStatus::kAlive;
  }
  count(value, *known->second);
  return *known->second;
}

void StatusColumn::count(std::string_view value, TreeStatus status) {
  const bool is_alive = status == TreeStatus::kAlive;
  if (value.empty()) {
    ++empty_;
  } else if (is_alive && data::is_missing_number(value)) {
    ++missing_;
  } else if (is_alive && first_alive_.empty()) {
    first_alive_ = value;
  }
  if ((value == "D" || value == "d") && is_by_letters()) ++(is_alive ? dominant_ : dead_letters_);
  if (status == TreeStatus::kDead) ++dead_;
  if (status == TreeStatus::kGone || status == TreeStatus::kFallen) ++gone_;
  if (status == TreeStatus::kNotInSample) ++not_in_sample_;
}

void StatusColumn::require_one_meaning(const std::string& file) const {
  const bool is_one = (has_crown_classes() ? dead_letters_ : dominant_) == 0;
  if (is_one) return;
  throw InputError(
      "D may be a dead tree or a dominant one: the first rows of the table and later "
      "ones have other letters beside it; explain it with `dead_codes=D` or "
      "`alive_codes=D`",
      {.file = file, .column = header_});
}

std::string StatusColumn::unknown_values() const {
  constexpr std::size_t kShown = 5;
  std::string text;
  std::size_t shown = 0;
  for (const auto& [value, count] : unknown_) {
    if (shown++ == kShown) return text + fmt::format(" and {} more", unknown_.size() - kShown);
    text += fmt::format("{}'{}' ({})", text.empty() ? "" : ", ", value, count);
  }
  return text;
}

std::string StatusColumn::remarks() const {
  std::string text;
  if (not_in_sample_ > 0) {
    text += fmt::format("; {} not in the sample, skipped", counted(not_in_sample_, "row", "rows"));
  }
  if (missing_ > 0) {
    text += fmt::format("; {} a missing status, used as alive",
                        counted(missing_, "row has", "rows have"));
  }
  if (if_true_ == TreeStatus::kAlive && empty_ > 0 && !first_alive_.empty() && dead_ + gone_ == 0) {
    text += fmt::format(
        "; {} empty and {} as living, although no row says that its tree is dead; if the empty "
        "ones are dead, use the others with `where={} == {}`",
        counted(empty_, "row is", "rows are"),
        empty_ == 1 ? "counts" : "count",
        data::Expression::variable(header_).text(),
        quoted_unless_number(first_alive_));
  }
  if (has_crown_classes() && dominant_ > 0) {
    text +=
        "; D, C, I and S are read as crown classes (dominant, codominant, intermediate, "
        "suppressed) of living trees; if D means dead, use `dead_codes=D`";
  }
  const std::string unknown = unknown_values();
  if (!unknown.empty()) {
    text += fmt::format(
        "; unknown status, used as alive: {}; explain them with `dead_codes`, `cut_codes` or "
        "`alive_codes`",
        unknown);
  }
  std::vector<std::string> unseen;
  for (const GivenCodes& list : lists_of(codes_)) {
    for (const std::string& code : *list.codes) {
      if (!seen_codes_.contains(code)) unseen.push_back(code);
    }
  }
  if (!unseen.empty()) text += "; no row has the status " + data::list_of(unseen);
  return text;
}

}  // namespace silvafit::stand
