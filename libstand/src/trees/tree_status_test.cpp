// SPDX-License-Identifier: MIT
// Status columns of published data and of field books. What each text means is what it says in its
// language.
#include "silvafit/stand/tree_status.hpp"

#include <catch2/catch.hpp>

#include "silvafit/base/error.hpp"
#include "test_support/inventory_test_support.hpp"
#include "trees/status_words.hpp"

using namespace silvafit::stand;
using Catch::Matchers::Contains;

namespace {

std::string words_of_status(std::string_view text, StatusText kind = StatusText::kStatus) {
  const auto status = status_in(text, kind);
  if (!status) return "unknown";
  switch (*status) {
    case TreeStatus::kAlive:
      return "alive";
    case TreeStatus::kDead:
      return "dead";
    case TreeStatus::kFallen:
      return "fallen";
    default:
      return "gone";
  }
}

/// A table with a column of one value per tree.
std::string table_of(const std::string& column, const std::vector<std::string>& values) {
  std::string text = "plot,tree,species,dbh," + column + "\n";
  for (std::size_t i = 0; i < values.size(); ++i) {
    text +=
        "1," + std::to_string(i + 1) + ",oak," + std::to_string(20 + i) + "," + values[i] + "\n";
  }
  return text;
}

std::size_t living(const std::string& column, const std::vector<std::string>& values) {
  return read_inventory_text(table_of(column, values)).inventory.size();
}

}  // namespace

TEST_CASE("dead trees are recognized in phrases") {
  for (const char* const text : {"Dead tree",
                                 "2 - dead",
                                 "2=dead",
                                 "D - dead",
                                 "Recently dead",
                                 "Dead, decay 2",
                                 "morta em pé",
                                 "Standing dead",
                                 "Dead (2015)",
                                 "Muerto en pie",
                                 "dead, broken top",
                                 "arbre mort",
                                 "toter Baum",
                                 "Árvore morta",
                                 "presumed dead",
                                 "not alive",
                                 "no longer alive",
                                 "dead; no bark",
                                 "枯死(2018)",
                                 "枯死",
                                 "Dead, broken bole",
                                 "dead spruce, bark beetles"}) {
    CAPTURE(text);
    CHECK(words_of_status(text) == "dead");
  }
}

TEST_CASE("living trees with dead parts are alive") {
  for (const char* const text : {"not dead",
                                 "dead top",
                                 "top dead",
                                 "top is dead",
                                 "dead branches",
                                 "partly dead",
                                 "half dead",
                                 "semi-dead",
                                 "alive, dead top",
                                 "Live, broken bole",
                                 "live, dead top",
                                 "nicht tot",
                                 "teilweise abgestorben",
                                 "ramas muertas y copa muerta",
                                 "alive with dead branches",
                                 "nearly dead",
                                 "Arbol vivo",
                                 "Live tree",
                                 "1 = live",
                                 "生存",
                                 "枯死枝"}) {
    CAPTURE(text);
    CHECK(words_of_status(text) == "alive");
  }
}

TEST_CASE("cut and fallen trees are recognized in phrases, and unclear ones are not") {
  CHECK(words_of_status("Cut 2018") == "gone");
  CHECK(words_of_status("Lost, presumed dead") == "gone");
  CHECK(words_of_status("dead - felled") == "gone");
  CHECK(words_of_status("dead and down") == "fallen");
  for (const char* const text : {"dead?",
                                 "alive/dead",
                                 "30 % dead",
                                 "beside dead oak",
                                 "to be felled",
                                 "dead on one side",
                                 "D - dominant",
                                 "dying",
                                 "tag: missing"}) {
    CAPTURE(text);
    CHECK(words_of_status(text) == "unknown");
  }
}

TEST_CASE("columns of other things are searched for clear words only") {
  CHECK(words_of_status("Dead", StatusText::kAny) == "dead");
  CHECK(words_of_status("stump, 2 sprouts", StatusText::kAny) == "gone");
  for (const char* const text :
       {"D", "missing", "lost", "down", "slope: down", "no height: missing"}) {
    CAPTURE(text);
    CHECK(words_of_status(text, StatusText::kAny) == "unknown");
  }
}

TEST_CASE("status columns of published data are found by their names") {
  // NEON's vegetation structure, Mexico's INFyS, Guyafor, and Japanese plots.
  CHECK(living("plantStatus", {"Live", "Standing dead", "\"Live,  insect damaged\"", "Downed"}) ==
        2);
  CHECK(living("Condicion", {"Arbol vivo", "Muerto en pie", "Tocón"}) == 1);
  CHECK(living("CodeAlive", {"TRUE", "FALSE", "TRUE"}) == 2);
  CHECK(living("状態", {"生存", "枯死", "倒木"}) == 1);
}

TEST_CASE("D beside other crown classes is a dominant tree") {
  const CheckedInventory read =
      read_inventory_text(table_of("Status", {"C", "D", "I", "S", "D", "C"}));
  CHECK(read.inventory.size() == 6);
  CHECK(has_note(read, "D, C, I and S are read as crown classes"));
  CHECK(living("Status", {"L", "D", "C"}) == 2);
  CHECK(living("Status", {"", "D", ""}) == 2);
  CHECK(living("Status", {"C", "D", "I", "dead"}) == 3);
  InventoryOptions options;
  options.status_codes.dead = {"D"};
  CHECK(read_inventory_text(table_of("Status", {"C", "D", "I"}), options).inventory.size() == 2);
}

TEST_CASE("letters that change their meaning after the first block are an error") {
  std::vector<std::string> values(5000, "");
  values[1] = "D";
  values.back() = "S";
  CHECK_THROWS_WITH(living("Status", values), Contains("D may be a dead tree or a dominant one"));
}

TEST_CASE("M is muerto beside V") {
  CHECK(living("status", {"V", "M", "V"}) == 2);
  // Vigorous, moderate, low.
  CHECK(living("health", {"V", "M", "L"}) == 3);
}

TEST_CASE("marks of columns that are named by their meaning") {
  CHECK(living("dead", {"x", "", "X", ""}) == 2);
  const CheckedInventory alive = read_inventory_text(table_of("alive", {"1", "", "1"}));
  CHECK(alive.inventory.size() == 3);
  CHECK(has_note(alive, "1 row is empty and counts as living"));
  CHECK(has_note(alive, "`where=alive == 1`"));
  CHECK_FALSE(has_note(read_inventory_text(table_of("alive", {"1", "", "0"})), "is empty and"));
}

TEST_CASE("columns of answers are read by what their names say in any language") {
  for (const char* const name : {"morta", "abgestorben", "död", "martwe", "standing_dead"}) {
    CAPTURE(name);
    CHECK(living(name, {"TRUE", "FALSE", "FALSE"}) == 2);
  }
  for (const char* const name : {"viva", "Survival", "survived", "is_living"}) {
    CAPTURE(name);
    CHECK(living(name, {"1", "0", "1"}) == 2);
  }
  CHECK(living("LD", {"L", "D", "L"}) == 2);
  // Names that may mean a size or a date, or have a year, are only asked about.
  for (const char* const name : {"harvested", "cut", "stump", "removed", "Mort_2020", "dead_11"}) {
    CAPTURE(name);
    const CheckedInventory read = read_inventory_text(table_of(name, {"TRUE", "FALSE", "FALSE"}));
    CHECK(read.inventory.size() == 3);
    CHECK(has_note(read, fmt::format("`columns=status={}`", name)));
    CHECK(has_note(read_inventory_text(table_of(name, {"A", "D", "A"})), "1 row has a word"));
    CHECK_FALSE(has_note(read_inventory_text(table_of(name, {"1", "0", "35.5"})), "living"));
    const CheckedInventory mapped = read_inventory_text(
        table_of(name, {"TRUE", "FALSE", "FALSE"}), with_columns(fmt::format("status={}", name)));
    CHECK(mapped.inventory.size() == 2);
  }
}

TEST_CASE("words of dead trees in any column of texts are noted") {
  for (const char* const column :
       {"CrownClass", "tree_class", "class", "vigor", "canopy", "cond", "obs", "damage"}) {
    CAPTURE(column);
    const CheckedInventory read =
        read_inventory_text(table_of(column, {"C", "dead", "I", "morta"}));
    CHECK(read.inventory.size() == 4);
    CHECK(
        has_note(read, "2 rows have a word of dead or cut trees in column " + std::string(column)));
  }
  // Of trees that are dead by their status anyway, and of dead parts, there is nothing to say.
  const CheckedInventory known = read_inventory_text(
      "plot,tree,dbh,status,remark\n1,1,20,A,dead top\n1,2,21,D,dead\n1,3,22,A,ok\n");
  CHECK(known.inventory.size() == 2);
  CHECK_FALSE(has_note(known, "a word of dead"));
  CHECK(has_note(read_inventory_text("plot,tree,dbh,status,remark\n1,1,20,A,\n1,2,21,A,dead\n"),
                 "1 row has a word of dead or cut trees in column remark"));
  // Names of stands are read.
  CHECK_FALSE(has_note(read_inventory_text("site,plot,tree,dbh\nDead Horse Creek,1,1,20\n"),
                       "a word of dead"));
}
