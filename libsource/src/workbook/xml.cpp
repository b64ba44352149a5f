// SPDX-License-Identifier: MIT
#include "workbook/xml.hpp"

#include <expat.h>
#include <fmt/format.h>

namespace silvafit::source {
namespace {

constexpr char kBetweenNamespaceAndName = '|';

std::string_view local_name(std::string_view name) {
  return name.substr(name.rfind(kBetweenNamespaceAndName) + 1);
}

struct FreeParser {
  void operator()(XML_ParserStruct* parser) const { XML_ParserFree(parser); }
};

/// A document that is read. Exceptions do not pass through expat, which is C.
class XmlDocument {
 public:
  explicit XmlDocument(XmlHandler& handler)
      : handler_(handler), parser_(XML_ParserCreateNS(nullptr, kBetweenNamespaceAndName)) {
    if (!parser_) throw std::bad_alloc();
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(parser_.get(), begin, end);
    XML_SetCharacterDataHandler(parser_.get(), text);
    XML_SetStartDoctypeDeclHandler(parser_.get(), refuse_document_type);
  }

  /// Returns false if the text is not well-formed or has a document type.
  bool add(std::string_view block, bool is_last) {
    const XML_Status status = XML_Parse(parser_.get(),
                                        block.data(),
                                        static_cast<int>(block.size()),
                                        is_last ? XML_TRUE : XML_FALSE);
    if (problem_) std::rethrow_exception(problem_);
    return status == XML_STATUS_OK;
  }

  std::size_t position() const {
    const XML_Index byte = XML_GetCurrentByteIndex(parser_.get());
    return byte < 0 ? 0 : static_cast<std::size_t>(byte);
  }

 private:
  template <typename Call>
  void guarded(const Call& call) {
    // Events of the same block follow after a stop.
    if (problem_) return;
    try {
      call();
    } catch (...) {
      problem_ = std::current_exception();
      XML_StopParser(parser_.get(), XML_FALSE);
    }
  }
  static XmlDocument& self(void* data) { return *static_cast<XmlDocument*>(data); }

  static void XMLCALL begin(void* data, const char* name, const char** attributes) {
    XmlDocument& document = self(data);
    document.guarded([&] {
      const std::string own(local_name(name));
      const std::string_view parent =
          document.open_.empty() ? std::string_view() : document.open_.back();
      document.handler_.begin({.name = own, .parent = parent, .attributes = attributes});
      document.open_.push_back(own);
    });
  }
  static void XMLCALL end(void* data, const char* name) {
    XmlDocument& document = self(data);
    document.guarded([&] {
      document.open_.pop_back();
      document.handler_.end(local_name(name));
    });
  }
  static void XMLCALL text(void* data, const char* piece, int length) {
    XmlDocument& document = self(data);
    document.guarded([&] { document.handler_.text({piece, static_cast<std::size_t>(length)}); });
  }
  static void XMLCALL refuse_document_type(void* data,
                                           const char* /*name*/,
                                           const char* /*system_id*/,
                                           const char* /*public_id*/,
                                           int /*has_internal_subset*/) {
    XML_StopParser(self(data).parser_.get(), XML_FALSE);
  }

  XmlHandler& handler_;
  std::unique_ptr<XML_ParserStruct, FreeParser> parser_;
  std::vector<std::string> open_{};
  std::exception_ptr problem_{};
};

}  // namespace

std::string_view XmlTag::attribute(std::string_view wanted) const {
  for (const char* const* at = attributes; *at != nullptr; at += 2) {
    const std::string_view own = *at;
    if (!own.ends_with(wanted)) continue;
    const std::size_t before = own.size() - wanted.size();
    // The parts of namespaces end with colons or slashes.
    if (before == 0 || std::string_view("|:/").find(own[before - 1]) != std::string_view::npos) {
      return at[1];
    }
  }
  return {};
}

bool is_blank(std::string_view text) {
  return text.find_first_not_of(" \t\r\n") == std::string_view::npos;
}

void read_xml(Archive& archive, const std::string& part, XmlHandler& handler) {
  XmlDocument document(handler);
  const auto add = [&](std::string_view block, bool is_last) {
    if (document.add(block, is_last)) return;
    archive.refuse(fmt::format("the XML of {} is broken at byte {}", part, document.position()));
  };
  archive.read(part, [&](std::string_view block) { add(block, false); });
  add({}, true);
}

}  // namespace silvafit::source
