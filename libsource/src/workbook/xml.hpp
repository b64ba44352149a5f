// SPDX-License-Identifier: MIT
// XML block by block, by expat.
#pragma once

#include <exception>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "workbook/archive.hpp"

struct XML_ParserStruct;

namespace silvafit::source {

/// The start of an element. Names have no prefixes, which every document chooses itself.
struct XmlTag {
  std::string_view name{};
  std::string_view parent{};                ///< name of the element around it; empty for the root
  const char* const* attributes = nullptr;  ///< names with namespaces, and values

  /// The value of an attribute; empty if there is none.
  /// \param wanted  its name, or the end of its namespace, a vertical bar and its name
  std::string_view attribute(std::string_view wanted) const;
};

/// UTF-8 with the escapes of XML. Control characters, which XML cannot contain, become U+FFFD.
inline std::string xml_text(std::string_view text) {
  std::string xml;
  for (const char c : text) {
    if (c == '&') {
      xml += "&amp;";
    } else if (c == '<') {
      xml += "&lt;";
    } else if (c == '>') {
      xml += "&gt;";
    } else if (c == '"') {
      xml += "&quot;";
    } else if (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') {
      xml += "\xEF\xBF\xBD";
    } else {
      xml += c;
    }
  }
  return xml;
}

/// Whether a text is only layout between tags.
bool is_blank(std::string_view text);

/// Receives the elements of a document.
class XmlHandler {
 public:
  virtual ~XmlHandler() = default;
  virtual void begin(const XmlTag& tag) = 0;
  virtual void end(std::string_view /*name*/) {}
  /// Text between tags, in pieces.
  virtual void text(std::string_view /*piece*/) {}
};

/// Reads a part of an archive as XML. Document types, and with them entities, are refused: with
/// them a short text can stand for a long one or for another file.
/// \throws InputError that names the part if it is missing, damaged or no XML; whatever the handler
///   throws
void read_xml(Archive& archive, const std::string& part, XmlHandler& handler);

}  // namespace silvafit::source
