// SPDX-License-Identifier: MIT
// The data and the HTML page of a study: the bundled template, filled with the data of
// docs/report-data.md.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "silvafit/study/catalogue.hpp"
#include "silvafit/study/study_record.hpp"

namespace silvafit::study {

/// The data of the report page, as docs/report-data.md describes them.
std::string report_data(const StudyRecord& record, const Catalogue& catalogue);

/// Writes a report page, whole or not at all. The same arguments give the same bytes.
///
/// \param template_path  the bundled page, `share/silvafit/viewer/report.html`
/// \param data_json      report data as docs/report-data.md describes them, UTF-8
/// \param title          plain text for the window's title; bytes that are not UTF-8 are replaced
/// \param out_path       the page; folders above it are made
/// \throws UsageError if the data are not JSON
/// \throws InputError if the template cannot be read or is not one; IoError if the page cannot be
/// written
void write_report_page(const std::filesystem::path& template_path,
                       std::string_view data_json,
                       const std::string& title,
                       const std::filesystem::path& out_path);

}  // namespace silvafit::study
