// SPDX-License-Identifier: MIT
// Objects that R holds by an external pointer.
#pragma once

#include <cpp11/R.hpp>
#include <cpp11/protect.hpp>
#include <cpp11/sexp.hpp>
#include <memory>
#include <string>
#include <utility>

#include "conversion.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::r {

template <class Object>
void own(SEXP handle, std::unique_ptr<Object> object) {
  const auto release = [](SEXP pointer) {
    delete static_cast<Object*>(R_ExternalPtrAddr(pointer));
    R_ClearExternalPtr(pointer);
  };
  cpp11::safe[R_RegisterCFinalizerEx](handle, release, TRUE);
  R_SetExternalPtrAddr(handle, object.release());
}

/// An external pointer to an object. It protects the text of the object, which saveRDS() writes.
template <class Object>
cpp11::sexp handle_of(Object object, const std::string& text) {
  const cpp11::sexp protected_text = value_of(text);
  const cpp11::sexp handle = cpp11::safe[R_MakeExternalPtr](nullptr, R_NilValue, protected_text);
  own(handle, std::make_unique<Object>(std::move(object)));
  return handle;
}

/// The object of a handle, which is parsed again after readRDS(). It lives as long as the handle.
/// \throws UsageError if the value is no handle
template <class Object, class Parse>
const Object& object_of(SEXP handle, const Parse& parse) {
  if (TYPEOF(handle) != EXTPTRSXP) throw UsageError("the object is of another version of silvafit");
  if (R_ExternalPtrAddr(handle) == nullptr) {
    own(handle, std::make_unique<Object>(parse(text_of(R_ExternalPtrProtected(handle)))));
  }
  return *static_cast<const Object*>(R_ExternalPtrAddr(handle));
}

}  // namespace silvafit::r
