// SPDX-License-Identifier: MIT
#include <pybind11/stl.h>

#include <nlohmann/json.hpp>
#include <string>

#include "arguments.hpp"
#include "reading.hpp"
#include "silvafit/study/grow.hpp"
#include "silvafit/study/view_page.hpp"
#include "studies.hpp"
#include "tables.hpp"
#include "work.hpp"

namespace silvafit::python {
namespace {

study::GrowSettings grow_settings(const py::dict& keywords) {
  Arguments arguments(keywords);
  study::GrowSettings settings{.reading = take_reading(arguments)};
  std::string builder;
  arguments.take("plots", settings.plots);
  arguments.take("use", settings.use);
  arguments.take("scene", settings.scene);
  arguments.take("out", settings.out);
  arguments.take("format", settings.format);
  arguments.take("builder", builder);
  arguments.take("preset", settings.preset);
  arguments.take("grammar", settings.grammar);
  arguments.take("lod", settings.levels);
  arguments.take("resolve_overlaps", settings.resolve_overlaps);
  arguments.take("share", settings.share);
  arguments.take("models", settings.models_per_preset);
  arguments.take("ground", settings.ground);
  arguments.take("instancing", settings.instancing);
  arguments.take("quantize", settings.quantize);
  arguments.take("compress", settings.compress);
  arguments.take("ascii", settings.ascii);
  arguments.take("textures", settings.textures);
  arguments.take("by", settings.by);
  arguments.take("animate", settings.animate);
  arguments.take("seconds", settings.seconds_per_unit);
  arguments.take("seed", settings.seed);
  arguments.take("threads", settings.threads);
  arguments.finish();
  if (!builder.empty()) settings.builder = tree::builder_from_text(builder);
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
  study::ViewPageSettings settings{.reading = take_reading(arguments)};
  arguments.take("title", settings.view.title);
  arguments.take("plots", settings.view.plots);
  arguments.take("models", settings.view.models_per_preset);
  arguments.take("lod", settings.view.levels);
  arguments.take("seed", settings.view.seed);
  arguments.take("threads", settings.view.threads);
  arguments.finish();
  const data::TableSource source = source_of(trees);
  return run(listener, [&](Work& work) {
    const auto catalogue = tree::PresetCatalogue::load(models);
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
