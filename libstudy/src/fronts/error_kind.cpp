// SPDX-License-Identifier: MIT
#include "silvafit/study/error_kind.hpp"

#include "silvafit/base/io_error.hpp"

namespace silvafit::study {

std::string_view error_kind(const Error& error) {
  const auto is = [&]<class Kind>(const Kind* /*kind*/) {
    return dynamic_cast<const Kind*>(&error) != nullptr;
  };
  // Derived classes are first.
  if (is(static_cast<const FormulaError*>(nullptr))) return "formula";
  if (is(static_cast<const UsageError*>(nullptr))) return "usage";
  if (is(static_cast<const DomainError*>(nullptr))) return "domain";
  if (is(static_cast<const InputError*>(nullptr))) return "input";
  if (is(static_cast<const NumericalError*>(nullptr))) return "numerical";
  if (is(static_cast<const GeometryError*>(nullptr))) return "geometry";
  if (is(static_cast<const IoError*>(nullptr))) return "io";
  return "other";
}

}  // namespace silvafit::study
