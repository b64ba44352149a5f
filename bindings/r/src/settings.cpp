// SPDX-License-Identifier: MIT
#include "settings.hpp"

#include <algorithm>
#include <cpp11/list.hpp>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/fit/setting_list.hpp"
#include "silvafit/stand/window.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/setting_list.hpp"

namespace silvafit::r {
namespace {

/// A ring is a matrix with the columns x and y.
std::vector<stand::Point> ring_of(SEXP matrix) {
  const std::vector<double> numbers = numbers_of(matrix);
  const std::size_t size = numbers.size() / 2;
  std::vector<stand::Point> ring(size);
  for (std::size_t i = 0; i < size; ++i) ring[i] = {numbers[i], numbers[size + i]};
  return ring;
}

/// The polygons of one window: a list of polygons, each a list of rings with the outer one first.
stand::Window window_of(SEXP list) {
  const cpp11::list elements(list);
  std::vector<stand::Polygon> polygons;
  for (SEXP element : elements) {
    const cpp11::list rings(element);
    stand::Polygon polygon;
    for (R_xlen_t i = 0; i < rings.size(); ++i) {
      if (i == 0) {
        polygon.outer = ring_of(rings[i]);
      } else {
        polygon.holes.push_back(ring_of(rings[i]));
      }
    }
    polygons.push_back(std::move(polygon));
  }
  return stand::Window(polygons);
}

/// \param windows  a list of lists of polygons
/// \param plots    of each; empty: of the stand
std::vector<stand::NamedWindow> named_windows(SEXP windows, const std::vector<std::string>& plots) {
  const cpp11::list elements(windows);
  std::vector<stand::NamedWindow> result;
  for (R_xlen_t i = 0; i < elements.size(); ++i) {
    std::optional<std::string> plot;
    if (!plots.empty()) plot = plots.at(static_cast<std::size_t>(i));
    result.push_back({.plot = plot, .window = window_of(elements[i])});
  }
  return result;
}

}  // namespace

fit::FitModelOptions fit_options(const Arguments& options) {
  auto result = settings_of<fit::FitModelOptions>(options);
  options.read("threads", result.threads);
  return result;
}

study::UnitSettings unit_settings(const Arguments& arguments) {
  auto settings = settings_of<study::UnitSettings>(arguments);
  if (arguments.has("windows")) {
    std::vector<std::string> plots;
    arguments.read("window_plots", plots);
    settings.windows = named_windows(arguments["windows"], plots);
  }
  return settings;
}

study::SamplingSettings sampling_settings(const Arguments& arguments) {
  auto settings = settings_of<study::SamplingSettings>(arguments);
  if (arguments.has("plots")) settings.plots = source_of(arguments["plots"]);
  return settings;
}

study::StudyConfiguration study_settings(const Arguments& arguments,
                                         const study::Catalogue& catalogue) {
  study::StudyConfiguration settings{.study = settings_of<study::StudyOptions>(arguments),
                                     .reading = reading_settings(arguments),
                                     .units = unit_settings(arguments),
                                     .sampling = sampling_settings(arguments)};
  if (!arguments.has("config")) return settings;
  std::vector<std::string> given;
  arguments.read("given", given);
  return study::read_study_configuration(
      text_of(arguments["config"]),
      &catalogue,
      {.settings = std::move(settings), .is_given = [&given](std::string_view key) {
         return std::ranges::find(given, key) != given.end();
       }});
}

study::EquationSettings equation_settings(const Arguments& arguments) {
  auto settings = settings_of<study::EquationSettings>(arguments);
  if (arguments.has("data_folder")) settings.models = data_folder(arguments) / "models";
  return settings;
}

bool shows_progress(const Arguments& arguments) {
  bool shows = false;
  arguments.read("progress", shows);
  return shows;
}

std::filesystem::path data_folder(const Arguments& arguments) {
  return text_of(arguments["data_folder"]);
}

}  // namespace silvafit::r
