// SPDX-License-Identifier: MIT
// National inventories and networks, in the columns of their documentations.
#include <catch2/catch.hpp>
#include <cmath>

#include "silvafit/stand/sampling_design.hpp"
#include "test_support/inventory_test_support.hpp"

using namespace silvafit::stand;
using Catch::Matchers::Contains;

namespace {

std::vector<double> factors_of(const Inventory& trees) {
  REQUIRE(trees.expansion == "trees_per_ha");
  const auto values = trees.other.numbers("trees_per_ha");
  return {values.begin(), values.end()};
}

CheckedInventory read_known(const std::string& text) {
  return read_inventory_text(text, {.keeps_expansion = true});
}

}  // namespace

TEST_CASE("Spain's IFN is read in mm and gon, with the factors of its four circles") {
  const CheckedInventory read = read_known(
      "Estadillo,Cla,Subclase,nArbol,OrdenIf3,Rumbo,Distanci,Especie,Dn1,Dn2,Ht\n"
      "0004,A,1,1,001,100,4,023,100,120,5.5\n0004,A,1,2,001,300,8,045,200,210,9\n"
      "0004,A,1,3,001,0,14,045,300,300,12\n0004,A,1,4,001,399,24,045,500,520,17\n"
      "0004,A,1,5,000,0,24,045,0,0,\n");
  const Inventory& trees = read.inventory;
  REQUIRE(trees.dbh_cm.size() == 5);
  CHECK(trees.plot[0] == "0004-A-1");
  CHECK(trees.dbh_cm[0] == 11.0);
  CHECK(trees.x[0] == Approx(4.0).epsilon(1e-12));
  CHECK(trees.x[1] == Approx(-8.0).epsilon(1e-12));
  CHECK(trees.y[2] == Approx(14.0).epsilon(1e-12));
  // 10,000 m2 over circles of 5, 10, 15 and 25 m, as IFNallometry of the R package medfate has
  // them.
  const auto factors = factors_of(trees);
  CHECK(factors[0] == Approx(127.3239546).epsilon(1e-8));
  CHECK(factors[1] == Approx(31.83098885).epsilon(1e-8));
  CHECK(factors[2] == Approx(14.14710607).epsilon(1e-8));
  CHECK(factors[3] == Approx(5.092958185).epsilon(1e-8));
  CHECK(std::isnan(trees.dbh_cm[4]));
  CHECK(has_note(read, "PCMayores of Spain's IFN"));
}

TEST_CASE("Spain's trees with one of two diameters have that one") {
  const CheckedInventory read = read_known(
      "Estadillo,nArbol,Rumbo,Distanci,Especie,Dn1,Dn2,Ht\n1,1,100,4,23,100,0,5\n"
      "1,2,200,4,23,300,0,9\n1,3,300,4,23,0,200,9\n");
  CHECK(read.inventory.dbh_cm == std::vector<double>{10.0, 30.0, 20.0});
  CHECK(factors_of(read.inventory)[1] == Approx(14.14710607).epsilon(1e-8));
}

TEST_CASE("Spain's trees of the quality 6 are dead") {
  const CheckedInventory read = read_known(
      "Estadillo,nArbol,Especie,Dn1,Dn2,Ht,Calidad\n1,1,23,100,100,5,2\n1,2,23,200,200,9,6\n");
  CHECK(read.inventory.size() == 1);
  CHECK(has_note(read, "1 dead, 0 cut or gone"));
}

TEST_CASE("Germany's BWI is read in mm, dm, cm and gon, as angle counts of factor 4") {
  const CheckedInventory read = read_known(
      "Tnr;Enr;Bnr;Ba;Bhd;Hoehe;Azi;Hori;Tot\n1;1;1;20;200;185;100;350;0\n"
      "1;2;1;10;400;301;200;450;0\n1;2;2;10;300;250;0;200;1\n");
  const Inventory& trees = read.inventory;
  REQUIRE(trees.size() == 2);
  CHECK(trees.plot[0] == "1-1");
  CHECK(trees.plot[1] == "1-2");
  CHECK(trees.dbh_cm[0] == 20.0);
  CHECK(trees.h_m[1] == Approx(30.1).epsilon(1e-12));
  CHECK(trees.x[0] == Approx(3.5).epsilon(1e-12));
  CHECK(trees.y[1] == Approx(-4.5).epsilon(1e-12));
  // 4 m2 per ha over the basal area of a tree of 20 cm, 0.0314159265 m2.
  CHECK(factors_of(trees)[0] == Approx(127.3239545).epsilon(1e-8));
}

TEST_CASE("Canada's dead standing trees are dead") {
  const CheckedInventory read = read_inventory_text(
      "nfi_plot,meas_date,tree_num,lgtree_genus,lgtree_species,lgtree_status,dbh,height\n"
      "9,2008-07-01,1,PICE,MAR,LS,29,23\n9,2008-07-01,2,PICE,MAR,DS,24,19\n"
      "9,2008-07-01,3,ABIE,BAL,LF,20,15\n");
  REQUIRE(read.inventory.size() == 2);
  CHECK(read.inventory.species[0] == "PICE-MAR");
  CHECK(has_note(read, "1 dead, 0 cut or gone"));
}

TEST_CASE("FIA's trees without TPA_UNADJ have the factors of the design") {
  // FIA's own factors: four subplots of 24 ft and, below 5 in, microplots of 6.8 ft per acre.
  const CheckedInventory read =
      read_known("PLT_CN,SUBP,TREE,STATUSCD,SPCD,DIA,HT\n9,1,1,1,316,10,60\n9,1,2,1,316,3,20\n");
  const auto factors = factors_of(read.inventory);
  CHECK(factors[0] * 0.40468564224 == Approx(6.018046).epsilon(1e-7));
  CHECK(factors[1] * 0.40468564224 == Approx(74.965282).epsilon(1e-7));
}

TEST_CASE("France's IFN is read with circumferences, weights and its codes of dead trees") {
  const CheckedInventory read = read_known(
      "CAMPAGNE;IDP;A;ESPAR;VEGET;C13;HTOT;W\n2019;100;1;02;0;0,628318530717959;15,5;39,3\n"
      "2019;100;2;02;Z;0,942;16;17,7\n2019;100;3;02;5;0,5;9;39,3\n2019;100;4;02;C;0,5;9;39,3\n");
  REQUIRE(read.inventory.size() == 2);
  CHECK(read.inventory.dbh_cm[0] == Approx(20.0).epsilon(1e-12));
  CHECK(read.inventory.h_m[0] == 15.5);
  CHECK(factors_of(read.inventory)[1] == 17.7);
  CHECK(has_note(read, "2 dead, 0 cut or gone"));
}

TEST_CASE("The second visit of a plot of France's IFN has its status in VEGET5") {
  // IGN: at the second visit VEGET and ESPAR are empty; 0 alive, 5 dead, 6 and 7 cut, N not found.
  const CheckedInventory read = read_known(
      "CAMPAGNE,IDP,A,ESPAR,VEGET,VEGET5,C13,HTOT,W\n2012,7,1,02,0,,0.942,18.5,39.3\n"
      "2012,7,2,02,0,,0.628,15.2,88.4\n2012,7,3,09,0,,1.257,21,39.3\n2012,7,4,09,5,,0.5,,88.4\n"
      "2017,7,1,,,0,1.005,,39.3\n2017,7,2,,,5,0.64,,88.4\n2017,7,3,,,6,,,39.3\n");
  REQUIRE(read.inventory.size() == 1);
  CHECK(read.inventory.tree[0] == "1");
  CHECK(read.inventory.dbh_cm[0] == Approx(100.5 / 3.14159265358979).epsilon(1e-14));
  CHECK(has_note(read, "2 dead, 1 cut or gone"));
}

TEST_CASE("ForestGEO's diameters are mm, and stems before and after their time are no trees") {
  const CheckedInventory read = read_known(
      "treeID,stemID,tag,sp,quadrat,gx,gy,MeasureID,CensusID,dbh,ExactDate,DFstatus,status\n"
      "1,1,a,INGLAU,721,5,6,11,5,308,2012-01-31,alive,A\n"
      "1,2,a,INGLAU,721,5,6,12,5,30,2012-01-31,alive,A\n"
      "2,3,b,CASSYL,721,9,6,13,5,NA,2012-01-31,dead,D\n"
      "3,4,c,CASSYL,721,9,6,14,5,NA,,prior,P\n4,5,d,CASSYL,721,9,6,15,5,NA,,lost_stem,G\n");
  const Inventory& trees = read.inventory;
  REQUIRE(trees.size() == 2);
  CHECK(trees.dbh_cm[0] == 30.8);
  CHECK(trees.tree[1] == "1-2");
  CHECK(trees.x[0] == 5.0);
  CHECK(has_note(read, "1 dead, 1 cut or gone"));
  CHECK(has_note(read, "1 row not in the sample"));
  const CheckedInventory full = read_known(
      "DBHID,PlotName,Mnemonic,QuadratName,PX,PY,TreeID,StemID,DBH,ExactDate,Status\n"
      "480614,luquillo,INGLAU,721,125.75,413.14,108604,143326,30.8,2012-01-31,alive\n"
      "480615,luquillo,INGLAU,721,125.8,413.2,108605,143327,30,2012-01-31,broken below\n");
  REQUIRE(full.inventory.size() == 2);
  CHECK(full.inventory.dbh_cm[0] == Approx(3.08).epsilon(1e-14));
  CHECK(full.inventory.plot[0] == "luquillo");
  CHECK(full.inventory.y[0] == 413.14);
  // A table with other columns keeps its centimeters, and its own meaning of P.
  const CheckedInventory other = read_known("treeID,gx,gy,dbh,status\n1,5,6,30,A\n2,5,9,20,P\n");
  CHECK(other.inventory.size() == 2);
  CHECK(other.inventory.dbh_cm[0] == 30.0);
}

TEST_CASE("BIEN's stems and the growth plots of ICP Forests are read") {
  const CheckedInventory stems = read_known(
      "plot_name,subplot,scrubbed_species_binomial,individual_id,stem_code,stem_dbh_cm,"
      "stem_height_m,relative_x_m,relative_y_m\nBCI,1,Alseis blackiana,7,a,12.5,14,3,4\n");
  REQUIRE(stems.inventory.size() == 1);
  CHECK(stems.inventory.plot[0] == "BCI");
  CHECK(stems.inventory.h_m[0] == 14.0);
  CHECK(stems.inventory.species[0] == "Alseis blackiana");
  const CheckedInventory growth = read_known(
      "survey_year;code_country;code_plot;tree_number;code_tree_species;diameter;height;"
      "code_removal\n2010;4;1203;1;134;31.5;28;1\n2010;4;1203;2;134;20.5;;31\n"
      "2010;4;1203;3;134;20.5;;14\n");
  REQUIRE(growth.inventory.size() == 1);
  CHECK(growth.inventory.plot[0] == "4-1203");
  CHECK(growth.inventory.dbh_cm[0] == 31.5);
  CHECK(has_note(growth, "1 dead, 1 cut or gone"));
}
