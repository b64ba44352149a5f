// SPDX-License-Identifier: MIT
// The HTML page that compares model libraries.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "silvafit/study/model_library.hpp"

namespace silvafit::study {

/// The data of a comparison page, as docs/report-data.md describes them, schema
/// silvafit-comparison/1: for each species, response and role that any library has, the fits side
/// by side, the differences of AIC, BIC, RMSE and R2 from the first library, and the curves over
/// DBH.
///
/// AIC and BIC are compared only between converged fits of the same response to the same values
/// (response_fingerprint; without it, as many trees of files with the same fingerprint) by the same
/// likelihood (ML or REML); otherwise their difference is null and a sentence says why. Curves are
/// population predictions (b = 0) over the union of the fitted DBH ranges, each within its own
/// range; other columns are held at the middle of the range that the fits have in common, height
/// comes from the library's own height model.
/// \param names  names of the libraries on the page: their files
/// \throws UsageError if there are fewer than two libraries, or another number of names
std::string comparison_data(const std::vector<ModelLibrary>& libraries,
                            const std::vector<std::string>& names);

/// Writes the page of comparison_data, whole or not at all. The same arguments give the same bytes.
///
/// \param template_path  the bundled report page, `share/silvafit/viewer/report.html`
/// \throws UsageError as comparison_data; InputError as write_report_page
void write_comparison_page(const std::vector<ModelLibrary>& libraries,
                           const std::vector<std::string>& names,
                           const std::filesystem::path& template_path,
                           const std::filesystem::path& out_path);

}  // namespace silvafit::study
