// SPDX-License-Identifier: MIT
// Narrow texts of paths are UTF-8. std::filesystem::path converts them to wide characters by this
// facet of the standard library, whose own functions know only the character set of the C library,
// which has no UTF-8 here. In a static program, ours take their place: the linker takes all of them
// or none, because they are one object of the archive.
#include <codecvt>
#include <locale>

#pragma GCC diagnostic ignored "-Wdeprecated-declarations"

namespace {

const std::codecvt_utf8_utf16<wchar_t>& utf8() {
  // Never destroyed: files are removed while the process ends.
  static const auto& facet = *new std::codecvt_utf8_utf16<wchar_t>;
  return facet;
}

}  // namespace

namespace std {

using WideFacet = codecvt<wchar_t, char, mbstate_t>;

WideFacet::result WideFacet::do_out(state_type& state,
                                    const intern_type* from,
                                    const intern_type* from_end,
                                    const intern_type*& from_next,
                                    extern_type* to,
                                    extern_type* to_end,
                                    extern_type*& to_next) const {
  return utf8().out(state, from, from_end, from_next, to, to_end, to_next);
}

WideFacet::result WideFacet::do_in(state_type& state,
                                   const extern_type* from,
                                   const extern_type* from_end,
                                   const extern_type*& from_next,
                                   intern_type* to,
                                   intern_type* to_end,
                                   intern_type*& to_next) const {
  return utf8().in(state, from, from_end, from_next, to, to_end, to_next);
}

int WideFacet::do_length(state_type& state,
                         const extern_type* from,
                         const extern_type* end,
                         size_t most) const {
  return utf8().length(state, from, end, most);
}

int WideFacet::do_encoding() const throw() { return utf8().encoding(); }

int WideFacet::do_max_length() const throw() { return utf8().max_length(); }

}  // namespace std
