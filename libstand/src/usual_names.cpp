// SPDX-License-Identifier: MIT
// The table of usual column names: English, German, French, Spanish, Portuguese, Italian, Swedish,
// Finnish, Polish, Chinese and Japanese.
#include "usual_names.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>

#include "folded_text.hpp"
#include "silvafit/data/csv.hpp"

namespace silvafit::stand {
namespace {

/// Spellings of a standard name in the form of folded_letters, with blanks between them.
struct UsualNames {
  std::string_view name{};
  std::string_view usual{};
  std::string_view vague{};  ///< ambiguous names, used only if no column has a usual name
};

constexpr std::array<UsualNames, 15> kNames{{
    {"plot",
     "plotid plotno plotnr plotnum plotnumber plotname plotcode sampleplot sampleplotid "
     "probeflache probeflaeche probeflachennr probeflaechennr probeflachenid probekreis "
     "probekreisnr stichprobe stichprobennr stichprobenr versuchsflache versuchsflaeche "
     "placette placetteid idplacette numplacette noplacette nplacette numeroplacette "
     "parcela parcelaid idparcela numparcela nparcela noparcela numeroparcela "
     "koeala koealaid koealanro koealanumero provyta provytanr powierzchnia "
     "样地 样地号 样地编号 样地名称 样方 样方号 样方编号 樣地 樣區 標準地 プロット",
     "parzelle parzellennr parcelle parcella 标准地 标准地号"},
    {"tree",
     "treeid treeno treenr treenum treenumber treename treetag baum baumnr baumid baumno "
     "baumnummer arbre arbreid idarbre numarbre noarbre narbre numeroarbre "
     "arbol arbolid idarbol numarbol noarbol narbol numeroarbol arvore idarvore numarvore albero "
     "puu puunro puuid puunumero tradnr tradid drzewo nrdrzewa "
     "树号 树编号 木号 单木号 样木号 立木号 林木编号 树木编号 株号 樹號 立木番号",
     "nr no num numero nummer id lfdnr lfnr laufendenummer stammnr 编号 序号"},
    {"species",
     "speciescode speciesid speciesname speciesabbr treespecies spp spcd speccode scientificname "
     "latinname baumart baumartnr baumartcode baumartencode baumartenkurzel holzart "
     "essence essenceforestiere espece especearbre especie especies nombrecientifico "
     "nombreespecie specie puulaji puulajit puulajikoodi tradslag gatunek "
     "树种 树种名 树种名称 树种代码 树种编号 樹種",
     "sp art taxon pl 种名"},
    {"x",
     "xcoord xcoordinate xcoordinates xkoord xkoordinate xkoordinaatti coordx coordonneex "
     "coordenadax xpos xposition posx xutm utmx easting rechtswert x坐标 横坐标",
     "xk 横坐标x"},
    {"y",
     "ycoord ycoordinate ycoordinates ykoord ykoordinate ykoordinaatti coordy coordonneey "
     "coordenaday ypos yposition posy yutm utmy northing hochwert y坐标 纵坐标",
     "yk 纵坐标y"},
    {"z", "zcoord zcoordinate zkoord zkoordinate coordz zpos posz z坐标", ""},
    {"dbh",
     "dbhob d13 d130 dbh13 dbh130 diameterbreastheight diameteratbreastheight "
     "diameter13 diameter13m diameter130 diameter130cm diameterat13m diametre13 diametre130 "
     "diametre130m diametrea130 diametrea130m diametro13 diametro130 diametroa130 diametroa130m "
     "bhd brusthohendurchmesser brusthoehendurchmesser dhp diametrehauteurpoitrine "
     "diametreahauteurdepoitrine dap diametronormal dnormal diametroalaalturadelpecho "
     "diametroaltezzapetto diametroalturadopeito lapimitta rinnankorkeuslapimitta "
     "brosthojdsdiameter piersnica 胸径 胸徑 胸高直径",
     "d dia diam diameter durchmesser diametre diametro dn 直径"},
    {"h",
     "height treeheight totalheight heighttotal hohe hoehe baumhohe baumhoehe gesamthohe "
     "gesamthoehe hauteur hauteurtotale htot htotal hauteurarbre altura alturatotal alturaarbol "
     "altezza altezzatotale pituus puunpituus hojd tradhojd wysokosc 树高 樹高 全高",
     "ht haut 高度"},
    {"hcb",
     "crownbase crownbaseheight heighttocrownbase heighttolivecrown livecrownbase hblc hlc "
     "kronenansatz kronenansatzhohe kronenansatzhoehe kronenbasis hauteurbasehouppier "
     "hauteurdebaseduhouppier basehouppier alturabasecopa alturabasedecopa "
     "alturabasedelacopa basecopa latvusraja latvusrajankorkeus elavanlatvuksenalaraja "
     "枝下高 活枝下高 冠基高 枝下高度",
     "kah"},
    {"cw",
     "crownwidth crowndiameter crowndiam crownwidthmean meancrownwidth kronenbreite "
     "kronendurchmesser diametrehouppier largeurhouppier diametrocopa diametrodecopa anchocopa "
     "latvuksenleveys latvusleveys latvuslapimitta 冠幅 平均冠幅 樹冠幅",
     ""},
    {"cr_e",
     "crownradiuse crownradiuseast kronenradiuso kronenradiusost rayonest 东冠幅 东半径",
     ""},
    {"cr_w",
     "crownradiusw crownradiuswest kronenradiusw kronenradiuswest rayonouest 西冠幅 西半径",
     ""},
    {"cr_s",
     "crownradiuss crownradiussouth kronenradiuss kronenradiussud rayonsud 南冠幅 南半径",
     ""},
    {"cr_n",
     "crownradiusn crownradiusnorth kronenradiusn kronenradiusnord rayonnord 北冠幅 北半径",
     ""},
    {"status",
     "treestatus treestate statuscd vitality alive living live dead deadalive aliveordead "
     "livedead zustand baumzustand baumstatus vitalitat lebend tot etat etatarbre statut vivant "
     "mort estado estadoarbol vivo muerto tila puuntila elossa kuollut "
     "状态 状况 生长状态 立木类型 存活 存活状态",
     ""},
}};

constexpr std::array<LengthUnit, 6> kUnits{
    {{"mm", 0.001}, {"cm", 0.01}, {"dm", 0.1}, {"m", 1.0}, {"in", 0.0254}, {"ft", 0.3048}}};

struct UnitWord {
  std::string_view word{};
  std::string_view unit{};
};
constexpr std::array<UnitWord, 16> kUnitWords{{{"inch", "in"},
                                               {"inches", "in"},
                                               {"zoll", "in"},
                                               {"\"", "in"},
                                               {"feet", "ft"},
                                               {"foot", "ft"},
                                               {"meter", "m"},
                                               {"meters", "m"},
                                               {"metre", "m"},
                                               {"metres", "m"},
                                               {"米", "m"},
                                               {"厘米", "cm"},
                                               {"公分", "cm"},
                                               {"毫米", "mm"},
                                               {"millimeter", "mm"},
                                               {"centimeter", "cm"}}};

/// A header in folded letters, split into a name and the words after it.
struct HeaderParts {
  std::string name{};
  std::optional<LengthUnit> unit{};
  bool has_other_unit = false;  ///< such as ha or degrees
};

bool is_separator(char c) {
  return c == ' ' || c == '_' || c == '.' || c == '/' || c == ',' || c == '-' || c == '(' ||
         c == '[' || c == ')' || c == ']' || c == ':' || c == ';';
}

/// Where a Latin word at the end of a text begins.
std::size_t last_word(std::string_view text) {
  std::size_t begin = text.size();
  while (begin > 0 && !is_separator(text[begin - 1])) --begin;
  return begin;
}

/// Whether a text ends with a number, as in `DBH (1.3 m)`: a height instead of a unit.
bool ends_with_height(std::string_view text) {
  const std::size_t blank = text.find_last_of(" _([");
  const std::string_view word = text.substr(blank == std::string_view::npos ? 0 : blank + 1);
  double ignored = 0.0;
  return data::parse_number(word, ignored);
}

/// Units that no measure has.
bool is_other_unit(std::string_view text) {
  constexpr std::array<std::string_view, 10> kOthers{
      "%", "°", "deg", "ha", "m2", "m²", "m3", "m³", "gon", "years"};
  return std::ranges::find(kOthers, text) != kOthers.end();
}

HeaderParts parts_of(std::string_view header) {
  std::string text = folded(header);
  // R replaces signs by dots, so that "DBH (cm)" becomes "DBH..cm.".
  while (!text.empty() && is_separator(text.back())) text.pop_back();
  const std::size_t begin = last_word(text);
  const std::string word = text.substr(begin);
  HeaderParts parts{.name = text};
  if (begin == 0) return parts;
  parts.unit = unit_of_length(word);
  parts.has_other_unit = !parts.unit && is_other_unit(word);
  if (!parts.unit) return parts;
  text.resize(begin);
  while (!text.empty() && is_separator(text.back())) text.pop_back();
  if (text.ends_with(" in")) text.resize(text.size() - 3);
  if (parts.unit->name == "m" && ends_with_height(text)) parts.unit.reset();
  parts.name = text;
  return parts;
}

/// Whether a list with blanks between its words has a word.
bool has_word(std::string_view list, std::string_view word) {
  for (std::size_t at = list.find(word); at != std::string_view::npos;
       at = list.find(word, at + 1)) {
    const bool begins = at == 0 || list[at - 1] == ' ';
    const std::size_t end = at + word.size();
    if (begins && (end == list.size() || list[end] == ' ')) return true;
  }
  return false;
}

/// The name without a remark in brackets at its end: `Höhe (gemessen)`.
std::string without_remark(const std::string& name) {
  const std::size_t open = name.find_first_of("([");
  return open == std::string::npos || open == 0 ? name : name.substr(0, open);
}

std::optional<MeantName> look_up(const std::string& key) {
  if (key.empty()) return std::nullopt;
  for (const UsualNames& names : kNames) {
    if (key == folded_letters(names.name)) return MeantName{names.name, NameFit::kSpelling};
  }
  for (const UsualNames& names : kNames) {
    if (has_word(names.usual, key)) return MeantName{names.name, NameFit::kUsual};
  }
  for (const UsualNames& names : kNames) {
    if (has_word(names.vague, key)) return MeantName{names.name, NameFit::kVague};
  }
  return std::nullopt;
}

bool is_label(std::string_view name) {
  return name == "plot" || name == "tree" || name == "species" || name == "status";
}

}  // namespace

std::optional<LengthUnit> unit_of_length(std::string_view text) {
  std::string name = folded(text);
  const auto word = std::ranges::find(kUnitWords, name, &UnitWord::word);
  if (word != kUnitWords.end()) name = word->unit;
  const auto unit = std::ranges::find(kUnits, name, &LengthUnit::name);
  return unit == kUnits.end() ? std::nullopt : std::optional(*unit);
}

std::optional<LengthUnit> unit_in_header(std::string_view header) { return parts_of(header).unit; }

std::optional<MeantName> meant_name(std::string_view header) {
  const HeaderParts parts = parts_of(header);
  if (parts.has_other_unit) return std::nullopt;
  std::optional<MeantName> meant = look_up(folded_letters(parts.name));
  if (!meant) meant = look_up(folded_letters(without_remark(parts.name)));
  if (meant && parts.unit && is_label(meant->name)) return std::nullopt;
  return meant;
}

}  // namespace silvafit::stand
