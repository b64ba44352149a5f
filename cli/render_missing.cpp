// SPDX-License-Identifier: MIT
// `silvafit render` in a program that was built without Embree or libpng.
#include "command.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::cli {

void add_render_command(CLI::App& program) {
  CLI::App& command =
      *program.add_subcommand("render", "Draw pictures of models and stands (not in this build)");
  command.allow_extras();
  command.callback([] {
    throw UsageError(
        "this silvafit was built without Embree or libpng, which pictures need; install "
        "libembree-dev and libpng-dev and build it with make build");
  });
}

}  // namespace silvafit::cli
