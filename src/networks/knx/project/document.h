#pragma once

#include <string>

#include "networks/knx/project/archive.h"
#include "networks/knx/project/kept_texts.h"
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

/// A document of which much is kept. It is refused at the bound of what the project may keep.
class KeepingDocument : public Document {
 protected:
  /// `texts` must outlive all that is kept.
  explicit KeepingDocument(KeptTexts& texts) : texts_(texts) {}

  KeptTexts& texts() { return texts_; }
  std::string_view keep(std::string_view text);
  /// The attribute as short_text() gives it.
  std::string_view keep(const xml::Attributes& attributes, std::string_view name);
  /// False, with the document refused, at the bound.
  bool charge(std::size_t bytes);

 private:
  KeptTexts& texts_;
};

/// True for `Enabled` and `true`, false for anything else; nullopt if the attribute is absent or empty.
std::optional<bool> enabled(const xml::Attributes& attributes, std::string_view name);

/// At most this many bytes of names, texts and ids are kept.
inline constexpr std::size_t kMaxText = 256;
/// The attribute without controls, cut to kMaxText.
std::string short_text(const xml::Attributes& attributes, std::string_view name);

}  // namespace rubicon::networks::knx::project
