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
  static const R_CallMethodDef kEntries[] = {SILVAFIT_ENTRY(words_of_messages),
                                             SILVAFIT_ENTRY(nearest_name),
                                             SILVAFIT_ENTRY(analysis),
                                             SILVAFIT_ENTRY(setting_list),
                                             SILVAFIT_ENTRY(formula_of_model),
                                             SILVAFIT_ENTRY(read_fit),
                                             SILVAFIT_ENTRY(text_of_fit),
                                             SILVAFIT_ENTRY(with_estimates),
                                             SILVAFIT_ENTRY(read_library),
                                             {nullptr, nullptr, 0}};
  R_registerRoutines(dll, nullptr, kEntries, nullptr, nullptr);
  R_useDynamicSymbols(dll, FALSE);
  R_forceSymbols(dll, TRUE);
}
