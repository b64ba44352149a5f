// SPDX-License-Identifier: MIT
// Registration of the functions that R calls.
#include <R_ext/Rdynload.h>

#include <cpp11/R.hpp>
#include <cpp11/declarations.hpp>

#include "conditions.hpp"
#include "entry_points.hpp"

namespace {

/// A function as R calls it: exceptions become values, and R's jumps continue.
template <auto function, class... Arguments>
SEXP called(Arguments... arguments) {
  BEGIN_CPP11
  return silvafit::r::guarded([&] { return function(arguments...); });
  END_CPP11
}

template <auto function, class... Arguments>
DL_FUNC pointer(SEXP (*)(Arguments...)) {
  return reinterpret_cast<DL_FUNC>(reinterpret_cast<void (*)()>(&called<function, Arguments...>));
}

template <class... Arguments>
constexpr int count(SEXP (*)(Arguments...)) {
  return static_cast<int>(sizeof...(Arguments));
}

}  // namespace

// The name has the prefix of the R code: fit_model becomes C_fit_model.
#define SILVAFIT_ENTRY(name) \
  { "C_" #name, pointer<silvafit::r::name>(&silvafit::r::name), count(&silvafit::r::name) }

extern "C" __attribute__((visibility("default"))) void R_init_silvafit(DllInfo* dll) {
  static const R_CallMethodDef kEntries[] = {
      SILVAFIT_ENTRY(words_of_messages),  SILVAFIT_ENTRY(fit_model),
      SILVAFIT_ENTRY(read_fit),           SILVAFIT_ENTRY(with_estimates),
      SILVAFIT_ENTRY(text_of_fit),        SILVAFIT_ENTRY(rows_of_fit),
      SILVAFIT_ENTRY(formula_of_model),   SILVAFIT_ENTRY(predict_fit),
      SILVAFIT_ENTRY(intervals_of_fit),   SILVAFIT_ENTRY(compare_fits),
      SILVAFIT_ENTRY(simulate_fit),       SILVAFIT_ENTRY(bootstrap_fit),
      SILVAFIT_ENTRY(cross_validate_fit), SILVAFIT_ENTRY(setting_list),
      SILVAFIT_ENTRY(structural_units),   SILVAFIT_ENTRY(stand_summary),
      SILVAFIT_ENTRY(stand_growth),       SILVAFIT_ENTRY(impute_table),
      SILVAFIT_ENTRY(study_of),           SILVAFIT_ENTRY(read_library),
      SILVAFIT_ENTRY(predict_library),    SILVAFIT_ENTRY(grow_trees),
      SILVAFIT_ENTRY(view_page),          {nullptr, nullptr, 0}};
  R_registerRoutines(dll, nullptr, kEntries, nullptr, nullptr);
  R_useDynamicSymbols(dll, FALSE);
  R_forceSymbols(dll, TRUE);
}
