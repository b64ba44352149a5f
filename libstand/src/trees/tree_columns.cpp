// SPDX-License-Identifier: MIT
// The table of the standard columns. Their usual names are English, German, French, Spanish,
// Portuguese, Italian, Swedish, Finnish, Polish, Chinese and Japanese.
#include "silvafit/stand/tree_columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "silvafit/data/missing_codes.hpp"
#include "silvafit/stand/inventory.hpp"

namespace silvafit::stand {
namespace {

constexpr std::array<TreeColumn, 19> kColumns{{
    {.name = "plot",
     .meaning = "plot",
     .usual = "plotid plotno plotnr plotnum plotnumber plotname plotcode sampleplot sampleplotid "
              "probeflache probeflaeche probeflachennr probeflaechennr probeflachenid probekreis "
              "probekreisnr stichprobe stichprobennr stichprobenr versuchsflache versuchsflaeche "
              "placette placetteid idplacette numplacette noplacette nplacette numeroplacette "
              "parcela parcelaid idparcela numparcela nparcela noparcela numeroparcela "
              "koeala koealaid koealanro koealanumero provyta provytanr powierzchnia nrpowierzchni "
              "flate upmid clnr areadisaggio numeroareadisaggio zkusnaplocha cislozkusneplochy "
              "proefvlak proefvlaknr "
              "proefperk ornekalan ornekalanno "
              "样地 样地号 样地编号 样地名称 样方 样方号 样方编号 樣地 樣區 標準地 プロット",
     .vague = "subplotid subplot transect transecto transekt parzelle parzellennr parcelle "
              "parcella stanowisko plocha 标准地 "
              "标准地号"},
    {.name = "tree",
     .meaning = "tree number",
     .usual = "treeid individualid arv narv numarv idtree treeno treenr treenum treenumber "
              "treename treetag baum baumnr baumid "
              "baumno "
              "baumnummer arbre arbreid idarbre numarbre noarbre narbre numeroarbre "
              "arbol arbolid idarbol numarbol noarbol narbol numeroarbol arvore idarvore numarvore "
              "trenr banr albero nalbero numeroalbero strom cislostromu boom boomnr boomnummer "
              "agac agacno "
              "puu puunro puuid puunumero tradnr tradid drzewo nrdrzewa "
              "树号 树编号 木号 单木号 样木号 立木号 林木编号 树木编号 株号 樹號 立木番号",
     .vague = "tag nr no num numero nummer id lfdnr lfnr laufendenummer stammnr 编号 序号"},
    {.name = "species",
     .meaning = "species",
     .usual = "speciescode spcode speciesid speciesname speciesabbr treespecies spp spcd speccode "
              "scientificname "
              "latinname baart baumart baumartnr baumartcode baumartencode baumartenkurzel holzart "
              "essence essenceforestiere espece especearbre especie especies nombrecientifico "
              "nombreespecie nomecient nomecientifico specie drevina boomsoort agacturu puulaji "
              "puulajit puulajikoodi tradslag gatunek "
              "树种 树种名 树种名称 树种代码 树种编号 樹種",
     .vague = "sp art taxon pl 种名"},
    {.name = "x",
     .meaning = "position to the east",
     .unit = "m",
     .usual = "gx xfield utmeast utmeasting utme xcoord xcoordinate xcoordinates xkoord "
              "xkoordinate xkoordinaatti coordx coordonneex "
              "coordenadax xpos xposition posx xutm utmx easting rechtswert x坐标 横坐标",
     .vague = "xk 横坐标x",
     .values = &Inventory::x},
    {.name = "y",
     .meaning = "position to the north",
     .unit = "m",
     .usual = "gy yfield utmnorth utmnorthing utmn ycoord ycoordinate ycoordinates ykoord "
              "ykoordinate ykoordinaatti coordy coordonneey "
              "coordenaday ypos yposition posy yutm utmy northing hochwert y坐标 纵坐标",
     .vague = "yk 纵坐标y",
     .values = &Inventory::y},
    {.name = "z",
     .meaning = "elevation",
     .unit = "m",
     .usual = "zcoord zcoordinate zkoord zkoordinate coordz zpos posz z坐标",
     .values = &Inventory::z},
    {.name = "dbh",
     .meaning = "diameter at breast height",
     .unit = "cm",
     .range = {.text = "above 0 cm", .largest = 1000.0},
     .usual =
         "stemdiameter dbhob d13 d130 dbh13 dbh130 diameterbreastheight diameteratbreastheight "
         "diameter13 diameter13m diameter130 diameter130cm diameterat13m diametre13 diametre130 "
         "diametre130m diametrea130 diametrea130m diametro13 diametro130 diametroa130 "
         "diametroa130m "
         "bhd brusthohendurchmesser brusthoehendurchmesser dhp diametrehauteurpoitrine "
         "diametreahauteurdepoitrine dap diametronormal dnormal diametroalaalturadelpecho "
         "diametroaltezzapetto diametroalturadopeito lapimitta rinnankorkeuslapimitta "
         "brosthojdsdiameter piersnica vycetnitloustka borsthoogtediameter goguscapi 胸径 胸徑 "
         "胸高直径",
     .vague = "d dia diam diameter durchmesser diametre diametro dn 直径",
     .values = &Inventory::dbh_cm,
     .converted =
         "cbh gbh girth circumference circumferencebreastheight girthbreastheight circonference "
         "pbh omtrek obwod obvod circonferenza "
         "circunferencia circunferencianormal umfang stammumfang brusthohenumfang cap c13 c130",
     .conversion = "/pi"},
    {.name = "h",
     .meaning = "total height",
     .unit = "m",
     .range = {.text = "above breast height, 1.3 m", .lowest = 1.3, .largest = 120.0},
     .usual = "treeht height treeheight totalheight heighttotal hohe hoehe baumhohe baumhoehe "
              "gesamthohe "
              "gesamthoehe hauteur hauteurtotale htot htotal hauteurarbre altura alturatotal "
              "alturaarbol "
              "vyska vyskastromu hoogte boomhoogte boy agacboyu altezza altezzatotale pituus "
              "puunpituus hojd tradhojd wysokosc 树高 樹高 全高",
     .vague = "th ht haut 高度",
     .values = &Inventory::h_m},
    {.name = "hcb",
     .meaning = "height to crown base",
     .unit = "m",
     .range = {.text = "0 m or more", .allows_lowest = true},
     .usual = "hbase crownbase crownbaseheight heighttocrownbase heighttolivecrown livecrownbase "
              "hblc hlc "
              "kronenansatz kronenansatzhohe kronenansatzhoehe kronenbasis hauteurbasehouppier "
              "hauteurdebaseduhouppier basehouppier alturabasecopa alturabasedecopa "
              "alturabasedelacopa basecopa latvusraja latvusrajankorkeus elavanlatvuksenalaraja "
              "枝下高 活枝下高 冠基高 枝下高度",
     .vague = "kah",
     .values = &Inventory::hcb_m},
    {.name = "cw",
     .meaning = "crown width",
     .unit = "m",
     .range = {.text = "above 0 m", .largest = 60.0},
     .usual =
         "crownwidth crowndiameter crowndiam crownwidthmean meancrownwidth kronenbreite "
         "kronendurchmesser diametrehouppier largeurhouppier diametrocopa diametrodecopa anchocopa "
         "latvuksenleveys latvusleveys latvuslapimitta 冠幅 平均冠幅 樹冠幅",
     .values = &Inventory::cw_m,
     .converted = "crad crownradius crownrad meancrownradius kronenradius rayonhouppier radiocopa",
     .conversion = "*2"},
    {.name = "cr_e",
     .meaning = "crown radius to the east",
     .unit = "m",
     .range = {.text = "0 m or more", .allows_lowest = true},
     .usual = "crownradiuse crownradiuseast kronenradiuso kronenradiusost rayonest 东冠幅 东半径",
     .vague = "re",
     .values = &Inventory::cr_e_m},
    {.name = "cr_w",
     .meaning = "crown radius to the west",
     .unit = "m",
     .range = {.text = "0 m or more", .allows_lowest = true},
     .usual =
         "crownradiusw crownradiuswest kronenradiusw kronenradiuswest rayonouest 西冠幅 西半径",
     .vague = "rw",
     .values = &Inventory::cr_w_m},
    {.name = "cr_s",
     .meaning = "crown radius to the south",
     .unit = "m",
     .range = {.text = "0 m or more", .allows_lowest = true},
     .usual = "crownradiuss crownradiussouth kronenradiuss kronenradiussud rayonsud 南冠幅 南半径",
     .vague = "rs",
     .values = &Inventory::cr_s_m},
    {.name = "cr_n",
     .meaning = "crown radius to the north",
     .unit = "m",
     .range = {.text = "0 m or more", .allows_lowest = true},
     .usual =
         "crownradiusn crownradiusnorth kronenradiusn kronenradiusnord rayonnord 北冠幅 北半径",
     .vague = "rn",
     .values = &Inventory::cr_n_m},
    {.name = "status",
     .meaning = "status (alive, dead, cut)",
     .usual =
         "plantstatus treehealth codealive treealive islive isliving lebt condicion condicionarbol "
         "estadoarvore condicao statusarvore dfstatus isdead isalive mortality snag health "
         "healthstatus stato stan stav vital "
         "vitalstatus condition treecondition treestatus treestate statuscd "
         "livestatus lifestatus alivedead vitality "
         "alive living live dead deadalive aliveordead "
         "livedead ld zustand baumzustand baumstatus vitalitat lebend tot etat etatarbre statut "
         "vivant "
         "mort estado estadoarbol vivo muerto tila puuntila elossa kuollut "
         "状态 状况 生长状态 立木类型 检尺类型 состояние treehistory 存活 存活状态 状態 生死 "
         "生死区分 立木状態"},
    // A position is made of these if it is not in the table: see usual_columns().
    {.name = "azimuth",
     .meaning = "direction from the point of measurement, clockwise from north",
     .unit = "degrees",
     .usual = "azimut azimutbaum azimuthdeg azimutgrad azimutdeg treeazimuth treeaz bearing acimut "
              "rumbo atsimuutti 方位角",
     .vague = "azm azi az"},
    {.name = "distance",
     .meaning = "horizontal distance from the point of measurement",
     .unit = "m",
     .usual = "horizontaldistance horizdist hdist hdistance treedistance treedist distanz abstand "
              "entfernung horizontalentfernung horizontaldistanz distancia distanza etaisyys "
              "水平距离 水平距",
     .vague = "dist 距离"},
    {.name = "x0",
     .meaning = "position of the point of measurement to the east",
     .unit = "m",
     .usual = "xcenter xcentre centerx centrex xcentro centrox xzentrum plotx plotcenterx"},
    {.name = "y0",
     .meaning = "position of the point of measurement to the north",
     .unit = "m",
     .usual = "ycenter ycentre centery centrey ycentro centroy yzentrum ploty plotcentery"},
}};

}  // namespace

std::string TreeColumn::meaning_with_unit() const {
  return unit.empty() ? std::string(meaning) : fmt::format("{} in {}", meaning, unit);
}

std::span<const TreeColumn> tree_columns() { return kColumns; }

const TreeColumn* tree_column(std::string_view name) {
  const auto* const found = std::ranges::find(kColumns, name, &TreeColumn::name);
  return found == kColumns.end() ? nullptr : found;
}

bool is_label(std::string_view name) {
  const TreeColumn* const column = tree_column(name);
  return column != nullptr && column->unit.empty() && name != "status";
}

bool is_measure(std::string_view name) {
  const TreeColumn* const column = tree_column(name);
  return column != nullptr && column->is_measure();
}

bool is_missing_number_of(std::string_view name, double value) {
  if (data::is_missing_code(value)) return true;
  // A tree may stand 999 m to the west of the origin.
  const TreeColumn* const column = tree_column(name);
  if (column != nullptr && column->is_position()) return false;
  return data::is_likely_missing_code(value);
}

bool is_zero_missing(std::string_view name) {
  const TreeColumn* const column = tree_column(name);
  return column != nullptr && !column->is_possible(0.0);
}

}  // namespace silvafit::stand
