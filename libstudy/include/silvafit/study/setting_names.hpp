// SPDX-License-Identifier: MIT
// The names of settings and commands in messages, as the program, R and Python write them.
#pragma once

#include <string>
#include <string_view>

namespace silvafit::study {

/// Where a message is shown.
enum class Front { kProgram, kR, kPython };

/// A message of the libraries in the words of a front end.
///
/// Messages have settings in backquotes: by the key (`buffer`), or with a value
/// (`method=focei`, `trust_units=true`, `columns=h=Height/10`). The program writes options:
/// --buffer, --method focei, --trust-units, --columns h=Height/10. R and Python write arguments:
/// `buffer`, method = "focei", trust_units = TRUE, columns = c(h = "Height/10"). Commands with a
/// function of the same purpose are functions there: `silvafit indices` is `structural_units()`.
/// Other words in backquotes stay.
std::string with_setting_names(std::string_view text, Front front);

/// The argument of R for a setting: the key, unless users of R have another word.
std::string_view argument_of_r(std::string_view key);

/// Place::column without the backquotes of a setting: the name of an argument of R or Python.
std::string name_of_place(std::string_view column);

}  // namespace silvafit::study
