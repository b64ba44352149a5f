// SPDX-License-Identifier: MIT
#include "fit_options.hpp"

#include "setting_keywords.hpp"
#include "silvafit/fit/setting_list.hpp"

namespace silvafit::python {

fit::FitModelOptions fit_options(const py::dict& keywords) {
  Arguments arguments(keywords);
  auto options = settings_of<fit::FitModelOptions>(arguments);
  arguments.take("threads", options.threads);
  arguments.finish();
  return options;
}

}  // namespace silvafit::python
