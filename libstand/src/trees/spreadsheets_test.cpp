// SPDX-License-Identifier: MIT
// Inventories exported from spreadsheets: names, units, codes and empty cells.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <string>

#include "silvafit/base/error.hpp"
#include "silvafit/stand/sampling_design.hpp"
#include "test_support/inventory_test_support.hpp"

using namespace silvafit::stand;
using Catch::Matchers::Contains;

TEST_CASE("columns with usual names are found if a file lacks the standard name") {
  const std::vector<std::string> header{"Plot_ID", "dbh", "DBH_cm", "Height", "x_m", "age"};
  const auto all_but = [](const std::string& known) {
    return [known](const std::string& name) { return name != known; };
  };
  const auto found = usual_columns(header, all_but("x"), "trees.csv");
  REQUIRE(found.size() == 2);
  CHECK(describe_usual_columns(found) == "plot is read from column Plot_ID, h from Height");
  CHECK_THROWS_WITH(usual_columns({"height", "hauteur"}, all_but("x"), "trees.csv"),
                    Contains("trees.csv: 'height' and 'hauteur' could both be h"));
  CHECK(usual_columns({"height", "hauteur"}, all_but("h"), "trees.csv").empty());
  // The standard name precedes a usual one, and that precedes an ambiguous one.
  CHECK(usual_columns({"height", "h_m"}, all_but("x"), "trees.csv").at(0).source == "h_m");
  CHECK(usual_columns({"d", "BHD"}, all_but("x"), "trees.csv").at(0).source == "BHD");
}

TEST_CASE("units in headers and in a row below them are converted to the standard units") {
  for (const char* text : {"plot,DBH_mm,h [dm],CW (ft)\n1,203,185,10\n",
                           "plot,dbh,h,cw\n,[mm],dm,ft\n1,203,185,10\n",
                           "plot,BHD in mm,Höhe/dm,\"Kronenbreite, ft\"\n1,203,185,10\n"}) {
    const Inventory inventory = read_inventory_text(text).inventory;
    REQUIRE(inventory.size() == 1);
    CHECK(inventory.dbh_cm[0] == 20.3);
    CHECK(inventory.h_m[0] == 18.5);
    CHECK(inventory.cw_m[0] == Approx(3.048).epsilon(1e-15));
  }
  const CheckedInventory mapped = read_inventory_text("a,b (mm),d1.3 (cm),DBH (1.3 m)\n1,203,4,5\n",
                                                      with_columns("dbh=b (mm)"));
  CHECK(mapped.inventory.dbh_cm[0] == 20.3);
  CHECK(has_note(mapped, "dbh is read from column `b (mm)`/10"));
  // Words in several languages, and remarks beside the unit.
  for (const char* header : {"DBH (millimeters)",
                             "\"DBH (mm, over bark)\"",
                             "dbh (mm) o.b.",
                             "Diameter (mm) at 1.3 m",
                             "DBH..mm..over.bark.",
                             "BHD in Millimeter",
                             "DAP [milímetros]"}) {
    INFO(header);
    CHECK(read_inventory_text(std::string(header) + "\n203\n").inventory.dbh_cm.at(0) == 20.3);
  }
  for (const char* header : {"\"DBH (inches, OB)\"", "\"DBH (\"\")\"", "Diameter (inches) at bh"}) {
    INFO(header);
    CHECK(read_inventory_text(std::string(header) + "\n10\n").inventory.dbh_cm.at(0) == 25.4);
  }
  const Inventory imperial = read_inventory_text("\"DBH (\"\")\",Height (')\n10,60\n").inventory;
  CHECK(imperial.h_m.at(0) == Approx(60 * 0.3048).epsilon(1e-15));
  CHECK(read_inventory_text("dbh,height (yd)\n20,20\n").inventory.h_m.at(0) ==
        Approx(20 * 0.9144).epsilon(1e-15));
  // Another height is no height of the tree.
  CHECK(read_inventory_text("dbh,h (m) to crown\n20,12\n").inventory.h_m.empty());
  // The breast height in a header is not a unit.
  CHECK(read_inventory_text("DBH (4.5 ft)\n20\n").inventory.dbh_cm.at(0) == 20.0);
  CHECK(read_inventory_text("DBH (1.3 m)\n20\n").inventory.dbh_cm[0] == 20.0);
  CHECK(read_inventory_text("d1.3 (mm)\n203\n").inventory.dbh_cm[0] == 20.3);
  // An expression is not converted.
  CHECK(read_inventory_text("DBH_mm\n20\n", with_columns("dbh=DBH_mm*1")).inventory.dbh_cm[0] ==
        20.0);
}

TEST_CASE("positions are made of azimuth and distance") {
  constexpr double kRounding = 1e-12;  // of a sine, times 50 m
  const CheckedInventory degrees =
      read_inventory_text("dbh,Azimut,Distanz [dm]\n20,90,100\n20,180,50\n20,,50\n");
  CHECK(degrees.inventory.x.at(0) == Approx(10.0).margin(kRounding));
  CHECK(degrees.inventory.y.at(0) == Approx(0.0).margin(kRounding));
  CHECK(degrees.inventory.y.at(1) == Approx(-5.0).margin(kRounding));
  CHECK(std::isnan(degrees.inventory.x.at(2)));
  CHECK(has_note(degrees, "(azimuth and distance)"));
  for (const char* text :
       {"dbh,Azimut [gon],dist\n20,100,10\n", "dbh,azimuth,dist\ncm,gon,m\n20,100,10\n"}) {
    CHECK(read_inventory_text(text).inventory.x.at(0) == Approx(10.0).margin(kRounding));
  }
  // From points of known position, with a declination of 10 degrees to the east.
  const auto from_points =
      read_inventory_text("dbh,needle,d,xcenter,ycenter\n20,80,10,600000,5e6\n",
                          with_columns("azimuth=needle+10,distance=d"));
  CHECK(from_points.inventory.x.at(0) == Approx(600010.0).epsilon(1e-15));
  CHECK(from_points.inventory.y.at(0) == Approx(5e6).epsilon(1e-15));
  // Coordinates precede, unless azimuth or distance are named.
  const char* const both = "dbh,x,y,azimuth,distance\n20,1,2,90,10\n";
  CHECK(read_inventory_text(both).inventory.x.at(0) == 1.0);
  CHECK(read_inventory_text(both, with_columns("azimuth=azimuth")).inventory.x.at(0) ==
        Approx(10.0).margin(kRounding));
  for (const std::string inches : {"dbh\"\"", "dbh (\"\")", "dbh ('')", "dbh''"}) {
    CHECK(read_inventory_text("plot,\"" + inches + "\"\n1,10\n").inventory.dbh_cm.at(0) ==
          Approx(25.4).epsilon(1e-15));
  }
  // A quarter of a circle in each unit.
  for (const auto& [unit, quarter] : std::map<std::string, std::string>{
           {"gon", "100"}, {"gr", "100"}, {"g", "100"}, {"mil", "1600"}, {"deg", "90"}}) {
    INFO(unit);
    const std::string text = "dbh,azimuth (" + unit + "),distance\n20," + quarter + ",10\n";
    CHECK(read_inventory_text(text).inventory.x.at(0) == Approx(10.0).margin(kRounding));
  }
  CHECK(read_inventory_text("dbh,azimuth (rad),distance\n20,1.5707963267948966,10\n")
            .inventory.x.at(0) == Approx(10.0).margin(kRounding));
  CHECK_THROWS_WITH(read_inventory_text("dbh,azimuth,distance\n20,90,10\n20,390,5\n"),
                    Contains(":3") && Contains("azimuth=azimuth*0.9"));
  CHECK_THROWS_WITH(read_inventory_text("dbh,azimuth,distance\n20,90,10\n20,-90,5\n"),
                    Contains("`columns=azimuth=ifelse(azimuth < 0, azimuth + 360, azimuth)`"));
  CHECK_THROWS_WITH(read_inventory_text("dbh,azimuth,distance\n20,90,10\n20,6390,5\n"),
                    Contains("azimuth=azimuth*360/6400"));
  CHECK_THROWS_WITH(read_inventory_text("dbh,azimuth,distance\n20,90,10\n20,90,-1\n"),
                    Contains("the distance -1 is negative"));
  CHECK_THROWS_WITH(read_inventory_text("dbh,azimuth,distance\n20,90,10\n20,6390,5\n",
                                        with_columns("azimuth=azimuth*0.9")),
                    Contains(":3") && Contains("the azimuth 5751"));
  CHECK_THROWS_WITH(read_inventory_text("dbh,richtung\n20,90\n", with_columns("azimuth=richtung")),
                    Contains("name the distance with `columns=distance=COLUMN`"));
}

TEST_CASE("azimuths in radians are asked about") {
  const auto around = [](double turn, int digits) {
    std::string text = "plot,tree,dbh,azimuth,distance\n";
    for (int tree = 0; tree < 12; ++tree) {
      text += fmt::format("1,{},20,{:.{}f},5\n", tree, turn * tree / 12.0, digits);
    }
    return text;
  };
  const std::string radians = around(2.0 * std::numbers::pi, 3);
  CHECK_THROWS_WITH(read_inventory_text(radians), Contains("`columns=azimuth=azimuth*180/pi`"));
  CHECK_NOTHROW(read_inventory_text(radians, {.trust_units = true}));
  CHECK_NOTHROW(
      read_inventory_text(radians, {.columns = parse_column_mappings("azimuth=azimuth*180/pi")}));
  CHECK_NOTHROW(read_inventory_text(around(360.0, 1)));
}

TEST_CASE("columns are found under the usual names of several languages") {
  const auto names = [](const std::string& header) {
    return describe_usual_columns(usual_columns(
        {header}, [](const std::string&) { return true; }, "trees.csv"));
  };
  const std::vector<std::pair<std::string, std::string>> known{
      {"plot", "Probefläche"},
      {"plot", "PLACETTE"},
      {"plot", "Parcela"},
      {"plot", "Koeala"},
      {"plot", "样地"},
      {"tree", "Baum-Nr."},
      {"tree", "N° arbre"},
      {"tree", "Puu nro"},
      {"tree", "树号"},
      {"species", "Baumart"},
      {"species", "Espèce"},
      {"species", "especie"},
      {"species", "Puulaji"},
      {"species", "树种"},
      {"dbh", "BHD"},
      {"dbh", "DAP (cm)"},
      {"dbh", "Läpimitta"},
      {"dbh", "胸径（cm）"},
      {"h", "HÖHE"},
      {"h", "Hoehe [m]"},
      {"h", "Hauteur_totale"},
      {"h", "altura"},
      {"h", "Pituus"},
      {"h", "树高"},
      {"hcb", "Kronenansatz"},
      {"hcb", "枝下高"},
      {"cw", "冠幅"},
      {"plot", "Area di saggio"},
      {"plot", "Proefvlak"},
      {"plot", "Örnek alan"},
      {"tree", "N. albero"},
      {"tree", "Strom"},
      {"tree", "Boomnr"},
      {"species", "Dřevina"},
      {"species", "NomeCient"},
      {"dbh", "Výčetní tloušťka"},
      {"dbh", "Göğüs çapı"},
      {"h", "Výška"},
      {"h", "Hoogte"},
      {"cw", "Kronenbreite"},
      {"h", "Ho\xCC\x88he"}};  // the accent as a character of its own
  for (const auto& [name, header] : known) {
    CHECK(names(header) == name + " is read from column " + header);
  }
  for (const char* header : {"Altitude", "BA", "h (°)", "Pflanzjahr", "hcb_note", ""}) {
    CHECK(names(header).empty());
  }
}

TEST_CASE("columns and words that say that trees are dead or gone are known") {
  for (const char* const header : {"is_dead", "mortality", "snag"}) {
    const std::string text =
        std::string("plot,tree,dbh,") + header + "\n1,1,20,1\n1,2,21,0\n1,3,22,0\n";
    CHECK(read_inventory_text(text).inventory.size() == 2);
  }
  CHECK(read_inventory_text("plot,tree,dbh,health\n1,1,20,healthy\n1,2,21,dead standing\n"
                            "1,3,22,dead (fallen)\n")
            .inventory.size() == 1);
  CHECK(read_inventory_text("plot,tree,dbh,tree_status\n1,1,20,Living\n1,2,21,Missing\n"
                            "1,3,22,Not found\n1,4,22,NA\n")
            .inventory.size() == 2);
}

TEST_CASE("dead trees are skipped, used only as neighbors, or used like others") {
  const std::string text =
      "plot,tree,species,x,y,dbh,Zustand\n1,1,SM,0,0,20,lebend\n1,2,SM,1,0,20,tot\n"
      "1,3,SM,0,1,,gefällt\n1,4,SM,1,1,20,?\n1,5,SM,1,2,20,krank\n";
  const CheckedInventory checked = read_inventory_text(text);
  CHECK(checked.inventory.size() == 3);
  CHECK(checked.inventory.neighbor_only.empty());
  CHECK(checked.excluded_tree_count == 2);
  CHECK(problems(checked) ==
        std::vector<std::string>{"3 Zustand: the tree is dead",
                                 "4 Zustand: the tree is cut, fallen or a stump"});
  CHECK(describe_excluded(checked).empty());
  CHECK(
      has_note(checked,
               "the status of trees is read from column Zustand: 1 dead, 1 cut or gone, skipped; "
               "with `dead=neighbors`, dead trees count as neighbors; 1 row has a missing status, "
               "used as alive; unknown status, used as alive: 'krank' (1)"));
  const CheckedInventory neighbors = read_inventory_text(text, {.dead = DeadTrees::kNeighbors});
  CHECK(neighbors.inventory.neighbor_only == std::vector<char>{0, 1, 0, 0});
  const CheckedInventory all = read_inventory_text(text, {.dead = DeadTrees::kInclude});
  CHECK(all.inventory.size() == 5);
  CHECK(all.inventory.neighbor_only == std::vector<char>{0, 0, 1, 0, 0});
}

TEST_CASE("spellings that differ only in case and blanks are one species") {
  const std::string text =
      "plot,tree,species,dbh\n1,1,sm,20\n1,2,SM ,20\n1,3,SM,20\n1,4,Sm,20\n1,5,-,20\n";
  const CheckedInventory checked = read_inventory_text(text);
  CHECK(checked.inventory.species.levels() == std::vector<std::string>{"SM"});
  CHECK(checked.inventory.species.is_missing(4));
  CHECK(has_note(checked, "'Sm' as 'SM' (1 tree), 'sm' as 'SM' (1 tree)"));
  CHECK(read_inventory_text(text, {.case_sensitive = true}).inventory.species.levels().size() == 3);
}

TEST_CASE("empty fields below a plot are filled down, or a message names the option") {
  const std::string text =
      "plot,tree,species,dbh\nA,1,SM,20\n,2,SM,20\n,3,,20\nB,1,SM,20\n,2,SM,20\n";
  const CheckedInventory empty = read_inventory_text(text);
  CHECK(empty.inventory.size() == 2);
  CHECK(has_note(empty,
                 "3 rows have a plot that is empty, as in merged cells; with `fill_down=plot`, the "
                 "value above is used"));
  const CheckedInventory filled = read_inventory_text(text, {.fill_down = {"plot", "species"}});
  CHECK(filled.inventory.size() == 5);
  CHECK(filled.inventory.plot[2] == "A");
  CHECK(filled.inventory.species[2] == "SM");
  CHECK_FALSE(has_note(filled, "empty"));
  // A label of several columns has the values above in each of them.
  const CheckedInventory joined =
      read_inventory_text("site,sub,tree,dbh\nN,1,1,20\n,,2,21\n,2,3,22\n",
                          {.columns = {{"plot", "site+sub"}}, .fill_down = {"plot"}});
  CHECK(joined.inventory.plot.levels() == std::vector<std::string>{"N-1", "N-2"});
  CHECK_THROWS_WITH(read_inventory_text(text, {.fill_down = {"stand"}}),
                    Contains("unknown column 'stand'"));
}

TEST_CASE("missing-value codes are recognized in columns of numbers") {
  const CheckedInventory checked = read_inventory_text(
      "plot,tree,species,dbh,h,hcb,cw\n1,1,SM,20,-,n/a,-999\n1,2,SM,20,#N/A,0,0\n"
      "1,3,SM,20,?,.,k.A.\n1,4,SM,20,-88,-9999,99\n",
      {.missing = {"-88", "99.0"}});
  CHECK(checked.inventory.size() == 4);
  CHECK(checked.excluded.empty());
  for (const double h : checked.inventory.h_m) CHECK(std::isnan(h));
  for (const double cw : checked.inventory.cw_m) CHECK(std::isnan(cw));
  CHECK(checked.inventory.hcb_m[1] == 0.0);
  CHECK(
      has_note(checked, "h 4 (-, #N/A, ?, -88), hcb 3 (n/a, ., -9999), cw 4 (-999, k.A., 99, 0)"));
}

TEST_CASE("FIA's table TREE is read with its units, places and labels") {
  // Sizes in inches and feet; Bechtold and Patterson 2005: subplot 3 lies 120 ft from the center at
  // 120 degrees, and saplings are measured from a microplot 12 ft east of the subplot's center.
  const std::string text =
      "CN,PLT_CN,INVYR,STATECD,UNITCD,COUNTYCD,PLOT,SUBP,TREE,AZIMUTH,DIST,STATUSCD,SPCD,DIA,HT,"
      "TPA_UNADJ\n"
      "11,901,2004,44,1,7,113,1,1,90,10,1,316,10,60,6.018046\n"
      "12,901,2004,44,1,7,113,3,1,360,20,1,316,8,50,6.018046\n"
      "13,901,2004,44,1,7,113,1,2,180,5,1,129,2,20,74.965282\n"
      "14,901,2004,44,1,7,113,1,3,NA,NA,0,129,NA,NA,NA\n"
      "15,901,2004,44,1,7,113,1,4,10,5,2,129,9,40,6.018046\n"
      "21,902,2009,44,1,7,113,1,1,90,10,1,316,11,64,6.018046\n";
  const CheckedInventory read = read_inventory_text(text, {.keeps_expansion = true});
  const Inventory& trees = read.inventory;
  REQUIRE(trees.size() == 4);
  CHECK(trees.plot[0] == "901");
  CHECK(trees.plot[3] == "902");
  CHECK(trees.tree[1] == "3-1");
  CHECK(trees.species[2] == "129");
  // Definitions of inch and foot.
  CHECK(trees.dbh_cm[0] == Approx(25.4).epsilon(1e-12));
  CHECK(trees.h_m[0] == Approx(18.288).epsilon(1e-12));
  CHECK(trees.x[0] == Approx(3.048).epsilon(1e-9));
  CHECK(trees.y[0] == Approx(0.0).margin(1e-9));
  CHECK(trees.x[1] == Approx(120.0 * std::sqrt(0.75) * 0.3048).epsilon(1e-7));
  CHECK(trees.y[1] == Approx((20.0 - 60.0) * 0.3048).epsilon(1e-7));
  CHECK(trees.x[2] == Approx(12.0 * 0.3048).epsilon(1e-9));
  CHECK(trees.y[2] == Approx(-5.0 * 0.3048).epsilon(1e-9));
  REQUIRE(trees.expansion == "trees_per_ha");
  CHECK(trees.other.numbers("trees_per_ha")[0] == Approx(6.018046 / 0.40468564224).epsilon(1e-12));
  CHECK(has_note(read, "the table is FIA's TREE, in inches and feet"));
  CHECK(problems(read).size() == 2);  // the dead tree, and the row that is not in the sample

  const CheckedInventory visits = read_inventory_text(text, {.keeps_measurements = true});
  CHECK(visits.inventory.plot[0] == "44-1-7-113");
  CHECK(visits.inventory.plot[visits.inventory.size() - 1] == "44-1-7-113");
  CHECK(visits.inventory.time[0] == "2004");
}

TEST_CASE("epithets of several genera are no species, and rows of no tree are no trees") {
  const std::string text =
      "plot,tree,genus,species,dbh\n1,1,Licania,alba,20\n1,2,Swartzia,alba,30\n";
  CHECK_THROWS_WITH(read_inventory_text(text),
                    Contains("'alba' occurs with the genera Licania and Swartzia") &&
                        Contains("`columns=species=genus + \" \" + species`"));
  const auto joined = read_inventory_text(text, with_columns("species=genus + \" \" + species"));
  CHECK(joined.inventory.species.levels() ==
        std::vector<std::string>{"Licania alba", "Swartzia alba"});
  CHECK(read_inventory_text("plot,tree,genus,species,dbh\n1,1,Licania,alba,20\n1,2,Swartzia,"
                            "benthamii,30\n")
            .inventory.size() == 2);
  CHECK_THROWS_WITH(read_inventory_text("plot,tree,count,dbh\n1,1,1,20\n1,2,0,30\n"),
                    Contains("count may be the number of trees"));
}

TEST_CASE("labels are joined of several columns") {
  const CheckedInventory read = read_inventory_text("stand,plot,no,dbh\nN,1,7,20\nS,1,7,30\n",
                                                    with_columns("plot=stand+plot,tree=no"));
  REQUIRE(read.inventory.size() == 2);
  CHECK(read.inventory.plot[0] == "N-1");
  CHECK(read.inventory.plot[1] == "S-1");
}

TEST_CASE("codes of the status are explained by the user") {
  const std::string text = "plot,tree,dbh,st\n1,1,20,LI\n1,2,21,ds\n1,3,22,DC\n1,4,23,3.0\n";
  InventoryOptions options = with_columns("status=st");
  CHECK(has_note(read_inventory_text(text, options), "explain them with `dead_codes`"));
  options.status_codes = {.alive = {"LI"}, .dead = {"DS", "3"}, .cut = {"DC", "X"}};
  const CheckedInventory read = read_inventory_text(text, options);
  CHECK(read.inventory.size() == 1);
  CHECK(has_note(read, "2 dead, 1 cut or gone, skipped"));
  CHECK(has_note(read, "no row has the status X"));
  options.status_codes = {.alive = {"DS"}, .dead = {"ds"}};
  CHECK_THROWS_WITH(read_inventory_text(text, options), Contains("'DS' is in `alive_codes` and"));
  options = with_columns("status=st == \"DS\"");
  CHECK_THROWS_WITH(read_inventory_text(text, options), Contains("status must be a column"));
  options = {.status_codes = {.dead = {"DS"}}};
  CHECK_THROWS_WITH(read_inventory_text(text, options), Contains("no column of the status"));
  options = with_columns("year=dbh + 1");
  CHECK_THROWS_WITH(read_inventory_text(text, options), Contains("year must be a column"));
}

TEST_CASE("the recommended unit makes trees of a possible shape") {
  // Seedlings of 2 m and 2.5 cm, in cm: tenths would make 20 m.
  std::string text = "plot,tree,dbh,h\n";
  for (int i = 1; i <= 12; ++i) text += "1," + std::to_string(i) + ",2.5,200\n";
  CHECK_THROWS_WITH(read_inventory_text(text),
                    Contains("in centimeters, use `columns=h=h/100`; if it is correct"));
  // 26 cm and 20 m, in feet; McMahon's limit of 95 (0.26)^(2/3) is 38.7 m.
  text = "plot,tree,dbh,h\n1,1,26,66\n1,2,27,67\n1,3,25,64\n";
  CHECK_THROWS_WITH(read_inventory_text(text),
                    Contains("if h is in feet, use `columns=h=h*0.3048`"));
  text = "plot,tree,dbh,h\n1,1,10.2,66\n1,2,10.6,67\n1,3,9.8,64\n";
  CHECK_THROWS_WITH(read_inventory_text(text),
                    Contains("if h is in feet and dbh is in inches, use "
                             "`columns=h=h*0.3048,dbh=dbh*2.54`; "));
  // FIA's names, in our units already: 64 "cm" and 6 "m" after the conversion.
  text = "PLT_CN,SUBP,TREE,SPCD,DIA,HT\n9,1,1,316,25,20\n9,1,2,316,26,21\n9,1,3,316,24,19\n";
  CHECK_THROWS_WITH(read_inventory_text(text),
                    Contains("if h is in meters already and dbh is in centimeters already, use "
                             "`columns=h=HT*1,dbh=DIA*1`"));
  // Stumps of 0.1 m beside diameters of 30 cm: no unit makes trees of them.
  const std::vector<double> stump_dbh(12, 30.5);
  const std::vector<double> stump_h(12, 0.1);
  const std::vector<SizeColumn> stumps{{"dbh", "dbh", stump_dbh}, {"h", "h", stump_h}};
  data::TextColumn one;
  for (int i = 0; i < 12; ++i) one.append("1");
  CHECK_THROWS_WITH(check_units_of_trees(one, one, stumps, "", [](std::size_t) { return Place(); }),
                    Contains("dbh has the median 30.5 cm") &&
                        Contains("with the median height 0.1 m by h; no usual units explain it"));
  // Circumferences of 1 m in centimeters, in a table of France's, which has them in meters.
  text = "idp,a,espar,c13,htot\n";
  for (int i = 1; i <= 12; ++i) text += fmt::format("7,{},52,{},22\n", i, 94 + i);
  CHECK_THROWS_WITH(read_inventory_text(text),
                    Contains("if dbh is in centimeters already, use `columns=dbh=(c13*100/3.14") &&
                        Contains(")/100`; if it is correct"));
  // The tallest trees and palms known, and saplings of 2.4 m with 1 cm.
  for (const char* giants : {"1,1,480,115.9", "1,1,40,60", "1,1,1,2.4"}) {
    CHECK_NOTHROW(read_inventory_text(std::string("plot,tree,dbh,h\n") + giants + "\n"));
  }
}

TEST_CASE("short names of crown radii need those of all directions") {
  const Inventory code =
      read_inventory_text("tree,dbh,h,crs\n1,20,15,2154\n2,21,16,2154\n").inventory;
  CHECK(code.cr_s_m.empty());
  const Inventory radii =
      read_inventory_text("tree,dbh,h,cre,crw,crs,crn\n1,20,15,1,2,3,4\n").inventory;
  CHECK(radii.cr_s_m == std::vector<double>{3.0});
}

TEST_CASE("trees whose numbers begin again are not those of one plot") {
  std::string text = "site,tree,dbh\n";
  int rows = 10;
  for (const char* site : {"a", "b", "c"}) {
    for (int tree = 1; tree <= 4; ++tree) {
      // Diameters differ, so that none is a copy.
      text += fmt::format("{},{},{}.{}\n", site, tree, 20 + tree, rows++);
    }
  }
  CHECK_THROWS_WITH(read_inventory_text(text),
                    Contains("no column plot") && Contains("available: site, tree, dbh"));
  CHECK_NOTHROW(read_inventory_text(text, with_columns("plot=site")));
}

TEST_CASE("FIA's positions do not choose the trees of subplots") {
  std::string text = "PLT_CN,SUBP,TREE,AZIMUTH,DIST,SPCD,DIA,HT\n";
  // Most are in subplot 1, whose center is that of the plot.
  for (int i = 1; i <= 6; ++i) text += "9,1," + std::to_string(i) + ",90,10,316,10,60\n";
  text += "9,3,1,90,10,316,10,60\n9,1,7,180,5,129,2,20\n";
  const Inventory trees = read_inventory_text(text).inventory;
  const SamplingDesign design{.circles = {{2.54, 2.07264}, {12.7, 7.3152}}, .subplots = 4};
  const DesignedSample sample = sample_of(trees, design);
  REQUIRE(sample.areas.size() == 1);
  CHECK(sample.areas[0].trees.size() == 8);
}
