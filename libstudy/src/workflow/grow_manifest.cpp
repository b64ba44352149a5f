// SPDX-License-Identifier: MIT
#include "workflow/grow_manifest.hpp"

#include <fmt/format.h>

#include "silvafit/data/csv.hpp"

namespace silvafit::study {

GrowManifest::GrowManifest(const std::string& file) : file_(file), rows_(file_.stream(), true) {
  file_.stream() << "plot,tree,species,preset,level,file,triangles,bytes\n";
}

void GrowManifest::add(std::size_t line, const GrownTree& grown) {
  const tree::SceneTree& tree = grown.tree;
  rows_.add(line,
            fmt::format("{},{},{},{},{},{},{},{}\n",
                        data::csv_field(tree.plot),
                        data::csv_field(tree.tree),
                        data::csv_field(tree.species),
                        data::csv_field(tree.preset),
                        grown.level,
                        data::csv_field(grown.file),
                        tree.measured.triangles,
                        grown.bytes));
}

void GrowManifest::finish() {
  rows_.finish();
  file_.commit();
}

}  // namespace silvafit::study
