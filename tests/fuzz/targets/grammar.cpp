// SPDX-License-Identifier: MIT
// A grammar, its string after its number of steps, and the turtle's drawing.
#include "fuzz_target.hpp"
#include "silvafit/tree/lsystem.hpp"
#include "silvafit/tree/turtle.hpp"

void silvafit::fuzz::read(std::string_view bytes) {
  constexpr tree::LsystemLimits kSmall{.modules = 20'000, .depth = 100, .operations = 1'000'000};
  const tree::Grammar grammar = tree::Grammar::parse(bytes, "grammar");
  Random random(1);
  const tree::ModuleString string = grammar.derive(random, {}, kSmall);
  tree::skeleton_of(tree::draw(string, grammar.turtle(), "grammar", kSmall), "grammar", 1);
}
