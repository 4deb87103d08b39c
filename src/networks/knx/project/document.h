#pragma once

#include <string>

#include "networks/knx/project/archive.h"
#include "networks/knx/xml/xml_parser.h"

namespace rubicon::networks::knx::project {

/// An XML entry of a project, read once in pieces. What is derived from it takes the elements.
class Document : public xml::Listener {
 public:
  /// The errors of Archive::read(), and those of the XML with entry and line.
  Result<void> read(const Archive& archive, const Archive::Entry& entry, const secure::Secret* password);
  /// The same for a whole document in memory.
  Result<void> read_text(std::string_view text);

 protected:
  xml::Parser& parser() { return parser_; }

 private:
  static constexpr std::size_t kMaxDepth = 256;  ///< application programs nest their choices

  xml::Parser parser_{*this, {kMaxDepth}};
};

/// True for `Enabled` and `true`, false for anything else; nullopt if the attribute is absent or empty.
std::optional<bool> flag_of(const xml::Attributes& attributes, std::string_view name);

/// At most this many bytes of names, texts and ids are kept.
inline constexpr std::size_t kMaxText = 256;
/// The attribute without controls, cut to kMaxText.
std::string short_text(const xml::Attributes& attributes, std::string_view name);

}  // namespace rubicon::networks::knx::project
