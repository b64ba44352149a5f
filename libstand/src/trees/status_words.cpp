// SPDX-License-Identifier: MIT
#include "trees/status_words.hpp"

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "silvafit/base/words.hpp"
#include "silvafit/data/csv.hpp"
#include "trees/folded_text.hpp"

namespace silvafit::stand {
namespace {

// Words in the form of folded_letters, with blanks between them.

constexpr std::string_view kAliveWords =
    "a l v alive live living healthy sound lebend lebendig vital gesund vivant vif sain viv vivo "
    "viva sano elava elossa terve levande frisk zywe 活 活立木 活木 存活 正常 健康 健在 生 生存 "
    "生木 "
    "生立木 保留木 进界木 живое растущее";
/// Those that are not also said of wood or leaves; with their endings.
constexpr std::string_view kAliveInPhrases =
    "alive live living lebend lebendig lebende lebender lebendes vivant vivante vivo viva elava "
    "elossa levande zywe zywy zywa";
constexpr std::string_view kDeadWords =
    "d dead standingdead deadstanding snag tot tote toter totes abgestorben abgestorbene "
    "abgestorbener durr duerr stehendtot totstehend stehendestotholz totholz durrstander mort "
    "morte mortsurpied muerto muerta muertoenpie seco seca morto morta kuollut kelo pystykuollut "
    "dod dott dood died mrtvy martwe martwy martwa 死 死亡 枯 枯死 枯死木 枯立木 死木 立枯 立枯れ "
    "枯損 枯損木 сухостой сухостойное";
constexpr std::string_view kGoneWords =
    "missing notfound lost disappeared verschwunden nichtgefunden cut cutdown felled harvested "
    "removed logged stump gefallt gefaellt entnommen geerntet "
    "genutzt eingeschlagen ausgeschieden baumstumpf stumpf stubben stock coupe coupee abattu "
    "abattue exploite recolte souche mortausol cortado cortada talado talada cosechado tocon "
    "hakattu kaadettu poistettu kanto avverkad stubbe 采伐 砍伐 伐倒 伐倒木 间伐 伐桩 树桩 "
    "伐根 已采伐 采伐木 间伐木 被伐木 伐採 伐採木 消失 пень спилено";
/// Those that are hardly said of anything but trees.
constexpr std::string_view kGoneInPhrases =
    "cutdown felled harvested stump gefallt gefaellt entnommen geerntet baumstumpf abattu abattue "
    "talado talada cortado cortada cosechado tocon hakattu kaadettu avverkad stubbe";
constexpr std::string_view kFallenWords =
    "fallen down downed deaddown downdead deadfallen fallendead lying windthrow windthrown "
    "umgefallen liegend liegendtot "
    "windwurf chablis caido caida kaatunut maapuu 倒木 枯倒木 валеж";
/// Words that mean something else in columns of heights, labels, slopes or persons.
constexpr std::string_view kVagueWords =
    "missing notfound lost disappeared verschwunden nichtgefunden removed logged down lying stock "
    "stumpf genutzt liegend kanto coupe exploite sound vital frisk";

constexpr std::string_view kNegations =
    "not no non nicht kein keine pas nao ei inte ikke nie never isn";
constexpr std::string_view kAfterNegations = "yet longer quite mehr encore plus aun ainda todavia";
constexpr std::string_view kPartly =
    "half semi partly partially part nearly almost near mostly halb teilweise teils beinahe fast "
    "presque partiellement demi casi parcialmente medio media quase meio meia parzialmente quasi "
    "mezzo mezza osittain puoliksi delvis halvt nastan";
constexpr std::string_view kParts =
    "top tops topped crown branch branches limb limbs twig twigs bark leader leaders shoot shoots "
    "sprout sprouts leaf leaves needle needles foliage litter tip tips side fork root roots "
    "ast aste aeste zweig zweige krone kronen wipfel gipfel zopf rinde nadel nadeln laub trieb "
    "triebe cime branche houppier ecorce rameau rameaux rama ramas copa apice punta corteza hoja "
    "hojas ramo ramos galho galhos casca folha folhas ponteiro cima chioma latva latvus oksa oksat "
    "kuori topp gren grenar";
constexpr std::string_view kBetween = "is are ist sind est sont es esta estan e";
/// The tree is beside a dead one, or is to be cut.
constexpr std::string_view kOtherTrees =
    "be soon beside next adjacent under neighbor neighbors neighbour neighbours nachbar "
    "nachbarbaum neben voisin vecino vizinho";

/// What a part of a text says.
enum class Said {
  kNothing,
  kPartlyDead,  ///< a living tree, unless the rest of the text says more
  kAlive,
  kDead,
  kGone,
  kFallen,
  kUnclear,
};

using Words = std::vector<std::string>;

bool is_letter_or_digit(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte >= 0x80 || (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z');
}

bool is_digits(std::string_view word) {
  return word.find_first_not_of("0123456789") == std::string_view::npos;
}

/// Letters alone are codes, such as those of species.
bool is_short_code(std::string_view word) { return word.size() < 3; }

/// The parts of a folded text between its signs, as words. A hyphen within a word is no sign.
std::vector<Words> parts_of(std::string_view text) {
  std::vector<Words> parts(1);
  std::string word;
  const auto end_word = [&] {
    if (!word.empty()) parts.back().push_back(std::exchange(word, {}));
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (is_letter_or_digit(text[i])) {
      word += text[i];
      continue;
    }
    const bool is_hyphen =
        text[i] == '-' && i > 0 && i + 1 < text.size() && text[i - 1] != ' ' && text[i + 1] != ' ';
    end_word();
    const bool is_in_words =
        is_hyphen || std::string_view(" _'").find(text[i]) != std::string::npos;
    if (!is_in_words && !parts.back().empty()) parts.emplace_back();
  }
  end_word();
  std::erase_if(parts, [](const Words& words) { return words.empty(); });
  return parts;
}

/// A word, or a part of a text without its numbers.
Said said_by_word(std::string_view word) {
  if (has_word(kAliveWords, word)) return Said::kAlive;
  if (has_word(kDeadWords, word)) return Said::kDead;
  if (has_word(kGoneWords, word)) return Said::kGone;
  return has_word(kFallenWords, word) ? Said::kFallen : Said::kNothing;
}

Said said_within_phrase(std::string_view word, StatusText kind) {
  const bool is_vague = kind == StatusText::kAny && has_word(kVagueWords, word);
  if (is_short_code(word) || is_vague) return Said::kNothing;
  if (has_word(kAliveInPhrases, word)) return Said::kAlive;
  if (has_word(kDeadWords, word)) return Said::kDead;
  if (has_word(kGoneInPhrases, word)) return Said::kGone;
  return has_word(kFallenWords, word) ? Said::kFallen : Said::kNothing;
}

/// Both in one text: a dead tree may also be a fallen one.
Said said_together(Said first, Said second) {
  if (first == Said::kNothing || first == second) return second;
  if (second == Said::kNothing) return first;
  if (first == Said::kPartlyDead) return second;
  if (second == Said::kPartlyDead) return first;
  const bool is_unclear = first == Said::kUnclear || second == Said::kUnclear;
  if (is_unclear || first == Said::kAlive || second == Said::kAlive) return Said::kUnclear;
  return first == Said::kDead ? second : first;
}

/// Whether a word stands directly before or after the one at a position, or with `is` between them.
bool is_beside(std::string_view list, const Words& words, std::size_t at) {
  const auto is_it = [&](std::size_t i) { return i < words.size() && has_word(list, words[i]); };
  if (is_it(at + 1) || (at > 0 && is_it(at - 1))) return true;
  const bool is_after_is = at > 1 && has_word(kBetween, words[at - 1]);
  return is_after_is && is_it(at - 2);
}

bool is_negated(const Words& words, std::size_t at) {
  if (at == 0) return false;
  if (has_word(kNegations, words[at - 1])) return true;
  return at > 1 && has_word(kAfterNegations, words[at - 1]) && has_word(kNegations, words[at - 2]);
}

bool is_partly(const Words& words, std::size_t at) {
  const std::size_t first = at < 2 ? 0 : at - 2;
  return std::any_of(words.begin() + static_cast<std::ptrdiff_t>(first),
                     words.begin() + static_cast<std::ptrdiff_t>(at),
                     [](const std::string& word) { return has_word(kPartly, word); });
}

/// What a word says among the others of its part.
Said said_at(const Words& words, std::size_t at, StatusText kind) {
  const Said said = said_within_phrase(words[at], kind);
  if (said == Said::kNothing) return said;
  const bool is_alive = said == Said::kAlive;
  if (is_negated(words, at)) return is_alive ? Said::kDead : Said::kAlive;
  if (is_beside(kParts, words, at)) return is_alive ? Said::kNothing : Said::kPartlyDead;
  if (is_alive) return said;
  if (is_partly(words, at)) return Said::kPartlyDead;
  const auto is_other = [](const std::string& word) {
    return has_word(kParts, word) || has_word(kOtherTrees, word);
  };
  return std::ranges::any_of(words, is_other) ? Said::kUnclear : said;
}

/// Chinese and Japanese have no blanks between words.
Said said_without_blanks(std::string_view word) {
  for (const std::string_view dead : {"枯死", "死亡", "枯立", "枯損"}) {
    const std::size_t at = word.find(dead);
    if (at == std::string_view::npos) continue;
    const auto before = word.substr(0, at);
    const auto after = word.substr(at + dead.size());
    const auto ends = [&](std::string_view sign) { return before.ends_with(sign); };
    const auto begins = [&](std::string_view sign) { return after.starts_with(sign); };
    if (ends("未") || ends("半") || ends("部分")) return Said::kPartlyDead;
    if (begins("枝") || begins("梢") || begins("叶") || begins("葉") || begins("率")) {
      return Said::kPartlyDead;
    }
    return Said::kDead;
  }
  return Said::kNothing;
}

Said said_by_part(const Words& words, bool is_first, StatusText kind) {
  std::string letters;
  for (const std::string& word : words) {
    if (!is_digits(word)) letters += word;
  }
  const bool is_vague = has_word(kVagueWords, letters);
  const bool is_read =
      !is_short_code(letters) && (!is_vague || (is_first && kind == StatusText::kStatus));
  if (is_read) {
    const Said said = said_by_word(letters);
    if (said != Said::kNothing) return said;
  }
  Said said = said_without_blanks(letters);
  for (std::size_t i = 0; i < words.size(); ++i)
    said = said_together(said, said_at(words, i, kind));
  return said;
}

/// A number or a letter before the words is a code: `2 - dead`, `D = dead`.
bool is_short_code(const Words& part) {
  return part.size() == 1 && (is_digits(part.front()) || is_short_code(part.front()));
}

Said said_by(std::string_view folded_text, StatusText kind) {
  Said said = Said::kNothing;
  bool is_first = true;
  for (const Words& part : parts_of(folded_text)) {
    if (is_short_code(part)) continue;
    said = said_together(said, said_by_part(part, is_first, kind));
    is_first = false;
  }
  const bool is_doubtful = folded_text.find_first_of("?%") != std::string_view::npos;
  return is_doubtful && said != Said::kNothing ? Said::kUnclear : said;
}

std::optional<TreeStatus> status_of(Said said) {
  switch (said) {
    case Said::kAlive:
    case Said::kPartlyDead:
      return TreeStatus::kAlive;
    case Said::kDead:
      return TreeStatus::kDead;
    case Said::kGone:
      return TreeStatus::kGone;
    case Said::kFallen:
      return TreeStatus::kFallen;
    default:
      return std::nullopt;
  }
}

}  // namespace

std::optional<TreeStatus> status_in(std::string_view text, StatusText kind) {
  const std::string letters = folded_letters(text);
  const bool is_searched = kind == StatusText::kAny;
  if (letters.empty() || (is_searched && is_short_code(letters))) return std::nullopt;
  const std::string plain = folded(text);
  const bool is_doubtful = plain.find_first_of("?%") != std::string::npos;
  const bool is_word = !is_doubtful && !(is_searched && has_word(kVagueWords, letters));
  const Said said = is_word ? said_by_word(letters) : Said::kNothing;
  return status_of(said == Said::kNothing ? said_by(plain, kind) : said);
}

std::optional<StatusOfHeader> status_of_header(std::string_view header) {
  constexpr std::string_view kOfHeaders = "survival survived survivor surviving lebt codealive";
  constexpr std::string_view kDeadOfHeaders = "mortality";
  std::string letters = folded_letters(header);
  const bool has_year = !letters.empty() && is_digits(letters.substr(letters.size() - 1));
  while (!letters.empty() && is_digits(letters.substr(letters.size() - 1))) letters.pop_back();
  if (letters.starts_with("is")) letters.erase(0, 2);
  if (is_short_code(letters)) return std::nullopt;
  const bool is_clear = !has_year && !has_word(kVagueWords, letters);
  if (has_word(kOfHeaders, letters)) return StatusOfHeader{TreeStatus::kAlive, is_clear};
  if (has_word(kDeadOfHeaders, letters)) return StatusOfHeader{TreeStatus::kDead, is_clear};
  switch (said_by_word(letters)) {
    case Said::kAlive:
      return StatusOfHeader{TreeStatus::kAlive, is_clear};
    case Said::kDead:
      return StatusOfHeader{TreeStatus::kDead, is_clear};
    // A stump or a harvest may also be a size or a date.
    case Said::kGone:
      return StatusOfHeader{TreeStatus::kGone};
    case Said::kFallen:
      return StatusOfHeader{TreeStatus::kFallen};
    default:
      return std::nullopt;
  }
}

std::optional<bool> answer_in(std::string_view value) {
  constexpr std::string_view kYes = "1 true t yes y ja j oui o si sim kylla tak ano 是";
  constexpr std::string_view kNo = "0 false f no n nein non nao ei nie ne 否";
  constexpr std::string_view kMarks = "x X + * ✓ ✔ √";
  const std::string word = folded_letters(value);
  if (has_word(kMarks, data::trimmed(value)) || has_word(kYes, word)) return true;
  if (has_word(kNo, word)) return false;
  return std::nullopt;
}

}  // namespace silvafit::stand
