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
#include "silvafit/data/table.hpp"
#include "trees/folded_text.hpp"
#include "trees/known_tables.hpp"

namespace silvafit::stand {
namespace {

/// Words in the form of folded_letters, with blanks between them.
constexpr std::string_view kAliveWords =
    "a l v alive live living healthy sound lebend lebendig vital gesund vivant vif sain viv vivo "
    "viva sano elava elossa terve levande frisk zywe 活 活立木 活木 存活 正常 健康 健在";
constexpr std::string_view kDeadWords =
    "d dead standingdead deadstanding snag tot abgestorben durr duerr stehendtot totstehend "
    "stehendestotholz totholz durrstander mort morte mortsurpied muerto muerta muertoenpie "
    "seco morto morta kuollut kelo pystykuollut dod martwe 死 死亡 枯死 枯死木 枯立木 死木 立枯";
constexpr std::string_view kGoneWords =
    "missing notfound lost disappeared verschwunden nichtgefunden cut cutdown felled harvested "
    "removed logged stump gefallt gefaellt entnommen geerntet "
    "genutzt eingeschlagen ausgeschieden baumstumpf stumpf stubben stock coupe coupee abattu "
    "abattue exploite recolte souche mortausol cortado cortada talado talada cosechado tocon "
    "cortada hakattu kaadettu poistettu kanto avverkad stubbe 采伐 砍伐 伐倒 伐倒木 间伐 伐桩 树桩 "
    "伐根 已采伐";
constexpr std::string_view kFallenWords =
    "fallen down deaddown downdead deadfallen fallendead lying windthrow windthrown umgefallen "
    "liegend liegendtot "
    "windwurf chablis caido caida kaatunut maapuu 倒木 枯倒木";
constexpr std::string_view kYes = "1 true t yes y ja j oui o si kylla 是";
constexpr std::string_view kNo = "0 false f no n nein non ei 否";

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

}  // namespace

StatusColumn::StatusColumn(std::string header,
                           StatusCodes codes,
                           const std::vector<std::string>& table)
    : header_(std::move(header)),
      table_(known_status_table(header_, table)),
      codes_(std::move(codes)) {
  check_codes(codes_);
  constexpr std::string_view kAliveHeaders =
      "alive isalive living live lebend vivant vivo elossa 存活";
  constexpr std::string_view kDeadHeaders = "dead isdead mortality snag tot mort muerto kuollut";
  const std::string name = folded_letters(header_);
  if (has_word(kAliveHeaders, name)) kind_ = Kind::kAlive;
  if (has_word(kDeadHeaders, name)) kind_ = Kind::kDead;
}

std::optional<TreeStatus> StatusColumn::meaning_of(std::string_view value) const {
  const std::string word = folded_letters(value);
  // A tree that is "missing" was not found.
  const bool is_gone = has_word(kGoneWords, word);
  if (word.empty() || (data::is_missing_number(value) && !is_gone)) return TreeStatus::kAlive;
  if (table_ != nullptr) {
    if (const auto known = known_status(*table_, value)) return known;
  }
  if (kind_ != Kind::kStatus) {
    const TreeStatus if_yes = kind_ == Kind::kAlive ? TreeStatus::kAlive : TreeStatus::kDead;
    const TreeStatus if_no = kind_ == Kind::kAlive ? TreeStatus::kDead : TreeStatus::kAlive;
    if (has_word(kYes, word)) return if_yes;
    if (has_word(kNo, word)) return if_no;
  }
  if (has_word(kAliveWords, word)) return TreeStatus::kAlive;
  if (has_word(kDeadWords, word)) return TreeStatus::kDead;
  if (is_gone) return TreeStatus::kGone;
  if (has_word(kFallenWords, word)) return TreeStatus::kFallen;
  return std::nullopt;
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
    const std::optional<TreeStatus> given = given_meaning(value);
    known = known_.emplace(std::string(value), given ? given : meaning_of(value)).first;
  }
  if (!known->second) {
    ++unknown_[known->first];
    return TreeStatus::kAlive;
  }
  const bool is_alive = *known->second == TreeStatus::kAlive;
  if (is_alive && !value.empty() && data::is_missing_number(value)) ++missing_;
  if (*known->second == TreeStatus::kDead) ++dead_;
  if (*known->second == TreeStatus::kGone || *known->second == TreeStatus::kFallen) ++gone_;
  if (*known->second == TreeStatus::kNotInSample) ++not_in_sample_;
  return *known->second;
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
