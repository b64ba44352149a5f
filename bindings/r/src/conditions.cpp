// SPDX-License-Identifier: MIT
#include "conditions.hpp"

#include <cpp11/protect.hpp>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "conversion.hpp"
#include "entry_points.hpp"
#include "silvafit/base/near_names.hpp"
#include "silvafit/study/error_kind.hpp"
#include "silvafit/study/setting_names.hpp"

namespace silvafit::r {
namespace {

std::string in_words_of_r(std::string_view message) {
  return study::with_setting_names(message, study::Front::kR);
}

cpp11::sexp failure(const std::string& kind, const std::string& text, const Place& place = {}) {
  NamedList result;
  result.add("kind", value_of(kind));
  result.add("message", value_of(text));
  result.add("column", value_of(study::name_of_place(place.column)));
  result.add("plot", value_of(place.plot));
  result.add("tree", value_of(place.tree));
  cpp11::sexp list = result.list();
  cpp11::safe[Rf_setAttrib](list, R_ClassSymbol, value_of(std::string("silvafit_failure")));
  return list;
}

}  // namespace

SEXP words_of_messages(SEXP texts) {
  std::vector<std::string> messages = texts_of(texts);
  for (std::string& message : messages) message = in_words_of_r(message);
  return value_of(messages);
}

SEXP nearest_name(SEXP name, SEXP names) {
  return value_of(silvafit::nearest_name(text_of(name), texts_of(names)));
}

SEXP guarded(const std::function<SEXP()>& work) {
  try {
    return work();
  } catch (const cpp11::unwind_exception&) {
    throw;  // a jump of R, which cpp11 continues
  } catch (const Error& error) {
    return failure(
        std::string(study::error_kind(error)), in_words_of_r(error.what()), error.place());
  } catch (const std::bad_alloc&) {
    return failure("memory", "there is not enough memory");
  } catch (const std::exception& error) {
    return failure("other", error.what());
  }
}

}  // namespace silvafit::r
