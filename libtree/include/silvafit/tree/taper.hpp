// SPDX-License-Identifier: MIT
// Stem taper: the diameter of a stem at each height, from DBH and tree height.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "silvafit/data/program.hpp"

namespace silvafit::tree {

/// A taper equation of the catalogue (models/taper/*.json): the diameter relative to DBH as a
/// formula of `x` (height on the stem [m]), `h` (tree height [m]) and `dbh` [cm].
class Taper {
 public:
  /// \throws InputError if the file cannot be used, or its equation is not 1 at 1.3 m and 0 at the
  /// tip
  static Taper load(const std::filesystem::path& file);

  const std::string& name() const { return name_; }
  const std::string& source() const { return source_; }

  /// Diameters at the heights [cm].
  ///
  /// Exactly `dbh_cm` at 1.3 m and 0 at the tip. Below 1.3 m, where equations of this kind
  /// extrapolate without bound for trees close to breast height, at most butt_limit() times
  /// DBH.
  /// \param heights_m  heights on the stem, in [0, h]
  /// \throws NumericalError if the equation gives no finite diameter
  std::vector<double> diameters_cm(std::span<const double> heights_m,
                                   double h_m,
                                   double dbh_cm) const;
  /// The same as radii [m].
  std::vector<double> radii_m(std::span<const double> heights_m, double h_m, double dbh_cm) const;

  /// Largest diameter at the butt, as a multiple of DBH.
  double butt_limit() const { return butt_limit_; }

 private:
  void check_ends(const std::string& file) const;

  std::string name_;
  std::string source_;
  data::Program program_;
  double butt_limit_ = 1.5;
};

/// Volume of the stem from the ground to the tip [m3]: the integral of the cross section
/// pi/4 d(x)^2 by Gauss and Legendre's rule of 5 points on 4 parts below breast height and 12
/// above.
/// \param h_m     > 1.3
/// \param dbh_cm  > 0
/// \throws NumericalError as Taper::diameters_cm
double stem_volume_m3(const Taper& taper, double h_m, double dbh_cm);

}  // namespace silvafit::tree
