// SPDX-License-Identifier: MIT
// The builders, which grow a tree from its measurements.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/base/enum_words.hpp"
#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/fitted_skeleton.hpp"
#include "silvafit/tree/mesh.hpp"
#include "silvafit/tree/morphology.hpp"
#include "silvafit/tree/preset.hpp"
#include "silvafit/tree/skeleton.hpp"
#include "silvafit/tree/smooth_mesh.hpp"
#include "silvafit/tree/species_map.hpp"

namespace silvafit::tree {

enum class BuilderKind { kSegment, kLsystem, kIfs, kBamboo };
constexpr std::array<std::string_view, 4> words_of(BuilderKind /*kind*/) {
  return {"segment", "lsystem", "ifs", "bamboo"};
}

/// A builder with one of its presets: grows any tree to its measurements.
///
/// For every builder, height, crown base, DBH and the four crown radii of the mesh are those of the
/// shape, and branches and foliage stay inside the crown.
class Builder {
 public:
  virtual ~Builder() = default;
  Builder(const Builder&) = delete;
  Builder& operator=(const Builder&) = delete;

  BuilderKind kind() const { return kind_; }
  virtual const PresetHead& preset() const = 0;
  const std::string& name() const { return preset().name; }

  /// Fills in missing measurements by the rules of the preset.
  /// \throws DomainError as validate()
  TreeShape shape_of(const Morphology& morphology) const;

  /// The stem first. The same random numbers give the same skeleton.
  /// \param mesh  for a mesh with pictures of shoots, leaf sites are left out, which saves time
  virtual Skeleton grow_skeleton(const TreeShape& shape,
                                 const Crown& crown,
                                 Random& random,
                                 const MeshOptions& mesh = {}) const = 0;

  /// The tree as the grammar or the function system draws it, in its own units; no measurement is
  /// fitted.
  /// \param h_m  selects the grammar of trees of that height
  /// \throws UsageError if the builder places its branches by the measurements; else as
  /// grow_skeleton()
  virtual Skeleton grow_freely(double h_m, Random& random) const;

  /// \throws UsageError if an option is out of range; GeometryError if a coordinate is not finite
  virtual Mesh build_mesh(const Skeleton& skeleton,
                          const Crown& crown,
                          Random& random,
                          const MeshOptions& options) const = 0;

 protected:
  explicit Builder(BuilderKind kind) : kind_(kind) {}

 private:
  BuilderKind kind_;
};

/// First-order branches in segments, as preset.hpp describes them.
///
/// Skeleton: stem by the preset's taper equation; first-order branches from the axis to the crown
/// curve; twigs inside it. In each of the four measured directions one branch ends at the crown's
/// widest point, and one branch starts on the axis at the crown base.
///
/// Mesh: tubes around the axes, and foliage on the branches' ends and twigs. A stem section is a
/// regular polygon with the area of the circle whose diameter the skeleton gives, so that diameters
/// and basal areas of the mesh are those of the tree. Height, crown base, crown radii and DBH are
/// the same at every level of detail. If the random numbers start from the same state, the levels'
/// foliage is at the same positions.
class SegmentBuilder : public Builder {
 public:
  /// \param models  folder with taper/, branch_count/, shoots/ and bark/
  /// \throws InputError naming file and field
  static std::unique_ptr<SegmentBuilder> load(const std::filesystem::path& models,
                                              const std::filesystem::path& file);

  explicit SegmentBuilder(Preset preset)
      : Builder(BuilderKind::kSegment), preset_(std::move(preset)) {}

  const Preset& preset() const override { return preset_; }

  Skeleton grow_skeleton(const TreeShape& shape,
                         const Crown& crown,
                         Random& random,
                         const MeshOptions& mesh = {}) const override;
  Mesh build_mesh(const Skeleton& skeleton,
                  const Crown& crown,
                  Random& random,
                  const MeshOptions& options) const override;

 private:
  Preset preset_;
};

/// The fields of presets whose skeletons grow without measurements.
struct FreePreset : PresetHead {
  double head = 0.0;  ///< as of fit_to_measurements
  SmoothStyle style{};
};

/// A builder that draws a tree freely and fits it to the measurements.
class FreeBuilder : public Builder {
 public:
  const FreePreset& preset() const override = 0;

  /// \throws GeometryError as fit_to_measurements, naming the file that was drawn
  Skeleton grow_skeleton(const TreeShape& shape,
                         const Crown& crown,
                         Random& random,
                         const MeshOptions& mesh = {}) const override;
  Mesh build_mesh(const Skeleton& skeleton,
                  const Crown& crown,
                  Random& random,
                  const MeshOptions& options) const override;

 protected:
  using Builder::Builder;

  /// The tree as grow_freely(), towards any azimuth; with leaf sites if they are needed.
  virtual Skeleton drawn(double h_m, bool has_leaves, Random& random) const = 0;
  /// The file with the drawing of trees of a height, for messages; or none.
  virtual std::string file_of(double h_m) const = 0;
};

/// The preset for a species.
struct PresetChoice {
  const Builder* builder = nullptr;
  bool is_listed = true;  ///< false: no preset lists the species, and this is the usual one
  std::string code_of{};  ///< the species, if the name was read as a code of the FIA
};

/// Collects what was assumed about species.
class SpeciesNotes {
 public:
  void add(const std::string& species, const PresetChoice& choice);
  /// Sentences, one for each kind of assumption.
  std::vector<std::string> texts() const;

 private:
  std::map<std::string, std::set<std::string>> unlisted_{};  ///< by preset
  std::map<std::string, std::string> codes_{};
};

/// The presets of all builders.
class BuilderCatalogue {
 public:
  /// \param models  folder with presets/, lsystems/, ifs/, bamboo/ and the files that these name
  /// \throws InputError naming the file and the field if an entry cannot be used
  static BuilderCatalogue load(const std::filesystem::path& models);

  /// Presets of a builder, in alphabetical order; at least one.
  std::vector<const Builder*> of(BuilderKind kind) const;

  /// Of the builder segment also the presets of others, because it draws all species.
  /// \throws UsageError with the available names
  const Builder& named(BuilderKind kind, std::string_view name) const;

  /// By the species that presets of the builder list, and by the species map. With the builder
  /// segment a palm, a banyan or a bamboo has the preset of its own builder.
  /// \param reads_codes  numbers are codes of FIA; else of another list, which is not known
  PresetChoice choose(BuilderKind kind, std::string_view species, bool reads_codes = true) const;

  /// The preset for species that no other preset lists: the one that lists "*".
  const Builder& fallback(BuilderKind kind) const;

  const SpeciesMap& species() const { return species_; }
  /// Names that choose a preset: its own, and those of the map; of species only those whose genus
  /// has another preset.
  std::vector<std::string> species_of(const Builder& builder) const;

 private:
  SpeciesMap species_{};
  std::vector<std::unique_ptr<const Builder>> builders_;
};

}  // namespace silvafit::tree
