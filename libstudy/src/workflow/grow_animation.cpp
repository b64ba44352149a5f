// SPDX-License-Identifier: MIT
// `silvafit grow --animate`: trees that grow over time, in one file.
#include <fmt/format.h>

#include <algorithm>

#include "silvafit/base/parallel.hpp"
#include "workflow/grow_job.hpp"

namespace silvafit::study {
namespace {

/// The stages of one tree while they are grown.
struct GrownStages {
  std::vector<tree::SceneTree> trees{};
};

class Animator {
 public:
  Animator(const GrowJob& job,
           const std::vector<tree::Moment>& moments,
           const std::vector<tree::Morphology>& stand,
           const tree::BuilderCatalogue& catalogue,
           const tree::Builder* for_all)
      : job_(job),
        moments_(moments),
        stand_(stand),
        growing_(tree::growing_trees(moments)),
        origin_(tree::scene_origin(stand)) {
    std::vector<tree::Morphology> first;
    for (const tree::GrowingTree& tree : growing_) first.push_back(tree.stages.front().tree);
    builders_ = choose_builders(first, catalogue, job, for_all);
    if (job.builder == tree::BuilderKind::kBamboo) {
      // Song et al. 2016, Scientific Reports 6: 25908: moso culms reach their final height and
      // diameter 38 days after they emerge.
      constexpr double kShooting = 38.0 / 365.0;
      pace_.growing_up = kShooting;
    }
    pace_.seconds_per_unit = job.seconds_per_unit;
  }

  GrowResult run() {
    tree::SceneOptions options = scene_options(job_, origin_);
    for (const tree::Moment& moment : moments_) {
      const double units = moment.time - moments_.front().time;
      options.times.push_back({.time_s = pace_.seconds_per_unit * units, .name = moment.name});
    }
    const auto writer = tree::open_scene(job_.scene, job_.scene_format, options);
    // A few at a time, so that memory does not grow with their number.
    constexpr std::size_t kBlock = 32;
    for (std::size_t from = 0; from < growing_.size(); from += kBlock) {
      std::vector<GrownStages> block(std::min(kBlock, growing_.size() - from));
      parallel_for(block.size(), job_.threads, [&](std::size_t k) { block[k] = grow(from + k); });
      for (std::size_t k = 0; k < block.size(); ++k) write(from + k, block[k], *writer);
      job_.show("growing", from + block.size(), growing_.size());
    }
    add_ground(job_, stand_, origin_, *writer);
    WrittenScene written{.name = job_.scene, .trees = growing_.size(), .triangles = triangles_};
    finish_scene(*writer, written);
    result_.files.push_back(std::move(written));
    return std::move(result_);
  }

 private:
  const tree::Builder& builder_of(std::size_t i) const { return *builders_[i].builder; }

  GrownStages grow(std::size_t i) const {
    const tree::GrowOptions options = grow_options(job_, job_.levels.front());
    GrownStages grown;
    for (const tree::Stage& stage : growing_[i].stages) {
      grown.trees.push_back(tree::grow_tree(stage.tree, builder_of(i), options));
    }
    return grown;
  }

  void write(std::size_t i, GrownStages& grown, tree::SceneWriter& writer) {
    const tree::GrowingTree& growing = growing_[i];
    const std::string name = grown.trees.front().name();
    std::vector<tree::SceneWriter::Model> models;
    for (std::size_t k = 0; k < grown.trees.size(); ++k) {
      const std::string& moment = moments_[growing.stages[k].moment].name;
      tree::SceneTree& tree = grown.trees[k];
      models.push_back(writer.add_model(fmt::format("{}@{}", name, moment),
                                        tree::parts_of(tree.mesh, tree.preset)));
      triangles_ += tree.measured.triangles;
      const std::size_t bytes = tree::glb_mesh_bytes(tree.mesh);
      tree.mesh = {};
      if (!job_.keeps_trees) continue;
      result_.trees.push_back({.tree = tree,
                               .file = job_.scene,
                               .bytes = bytes,
                               .level = job_.levels.front(),
                               .moment = moment});
    }
    writer.animate(name,
                   growing.stages.back().tree.position,
                   tree::animated(growing, moments_, models, pace_),
                   tree::tree_extras(grown.trees.back()));
  }

  const GrowJob& job_;
  const std::vector<tree::Moment>& moments_;
  const std::vector<tree::Morphology>& stand_;
  std::vector<tree::GrowingTree> growing_;
  tree::Position origin_;
  std::vector<tree::PresetChoice> builders_{};
  tree::Pace pace_{};
  std::size_t triangles_ = 0;
  GrowResult result_{};
};

}  // namespace

GrowResult write_animation(const GrowJob& job,
                           const std::vector<tree::Moment>& moments,
                           const std::vector<tree::Morphology>& stand,
                           const tree::BuilderCatalogue& catalogue,
                           const tree::Builder* for_all) {
  return Animator(job, moments, stand, catalogue, for_all).run();
}

}  // namespace silvafit::study
