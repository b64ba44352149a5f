// SPDX-License-Identifier: MIT
#include <pybind11/stl.h>

#include <nlohmann/json.hpp>
#include <string>

#include "reading.hpp"
#include "setting_keywords.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/grow_setting_list.hpp"
#include "silvafit/study/view_page.hpp"
#include "studies.hpp"
#include "tables.hpp"
#include "work.hpp"

namespace silvafit::python {
namespace {

study::GrowSettings grow_settings(const py::dict& keywords) {
  Arguments arguments(keywords);
  auto settings = settings_of<study::GrowSettings>(arguments);
  settings.reading = take_reading(arguments);
  arguments.take("seed", settings.seed);
  arguments.take("threads", settings.threads);
  arguments.finish();
  settings.keeps_trees = true;
  return settings;
}

std::string grow(const py::object& trees,
                 const std::string& models,
                 const py::dict& keywords,
                 const py::object& listener) {
  const study::GrowSettings settings = grow_settings(keywords);
  const data::TableSource source = source_of(trees);
  return run(listener, [&](Work& work) {
    const auto catalogue = tree::BuilderCatalogue::load(models);
    return study::json_of(study::grow(source, catalogue, settings, work.callbacks())).dump();
  });
}

/// \param page_template  the bundled page
std::string view(const py::object& trees,
                 const std::string& models,
                 const std::string& page_template,
                 const std::string& page,
                 const py::dict& keywords,
                 const py::object& listener) {
  Arguments arguments(keywords);
  study::ViewPageSettings settings{.reading = take_reading(arguments),
                                   .view = settings_of<study::ViewOptions>(arguments)};
  arguments.take("seed", settings.view.seed);
  arguments.take("threads", settings.view.threads);
  arguments.finish();
  const data::TableSource source = source_of(trees);
  return run(listener, [&](Work& work) {
    const auto catalogue = tree::BuilderCatalogue::load(models);
    const study::ViewPage written =
        study::write_view_page(source, catalogue, page_template, page, settings, work.callbacks());
    return study::json_of(written).dump();
  });
}

}  // namespace

void add_trees(py::module_& module) {
  module.def("grow", &grow);
  module.def("view", &view);
}

}  // namespace silvafit::python
