// SPDX-License-Identifier: MIT
// Labels that are not what they seem: different ones that are probably meant as one, codes of
// missing values, and those of rows of sums and means.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "silvafit/data/table.hpp"

namespace silvafit::stand {

/// A note on labels that differ only in case, accents, blanks, leading zeros or needless decimals,
/// such as `001`, `1` and `1.0`: labels are compared as text. Also on -9999 and n/a, codes
/// of missing values in columns of numbers. Empty if there are none.
/// \param of  what the labels name
std::string describe_similar_labels(const data::TextColumn& labels, const std::string& of = "plot");

/// Whether a label says that its row is a sum, mean or other figure of the rows above and no tree
/// or plot: Total, Summe, Mittelwert.
/// \param is_code  labels such as SD and MAX, which may be codes of species, do not count
bool is_summary_label(std::string_view label, bool is_code = false);
/// The same for labels such as `A Average` and `Total plot A`, too.
/// \param is_plot  whether there is such a plot
bool is_summary_label(std::string_view label, const std::function<bool(std::string_view)>& is_plot);

/// Refuses labels that a spreadsheet has shortened, 1.88785E+14 for a number of fifteen digits, and
/// ditto marks.
/// \param name    what the labels are: plot, tree or species
/// \param column  their column in the file
/// \throws InputError with the first such label
void refuse_unusable_labels(const data::TextColumn& labels,
                            std::string_view name,
                            const std::string& column,
                            const std::string& file);

}  // namespace silvafit::stand
