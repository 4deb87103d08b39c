#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <unordered_set>

#include "networks/knx/project/archive.h"
#include "networks/knx/xml/xml_parser.h"

namespace rubicon::networks::knx::project {

/// Bytes that one project may keep in memory while it is read: of names, texts and ids, and of what holds them. Each of
/// 65,535 addresses may have a name of 200 bytes, and be linked to two objects.
inline constexpr std::size_t kMaxKept = std::size_t{96} << 20U;

/// Keeps each text of a project once, and counts all that is kept of it. The documents of a project share one, so that
/// no combination of them takes more than the bound.
class KeptTexts {
 public:
  explicit KeptTexts(std::size_t most = kMaxKept) : most_(most) {}
  KeptTexts(const KeptTexts&) = delete;
  KeptTexts& operator=(const KeptTexts&) = delete;

  /// A copy that lives as long as this object; empty if it is beyond the bound.
  std::string_view keep(std::string_view text);
  /// Counts bytes that are kept elsewhere. False if they are beyond the bound: then they must not be kept.
  bool charge(std::size_t bytes);
  /// Something was beyond the bound: the project is to be refused.
  bool is_exceeded() const { return exceeded_; }
  /// The sentence for that.
  std::string why() const;

 private:
  struct Hash : std::hash<std::string_view> {
    using is_transparent = void;
  };

  std::unordered_set<std::string, Hash, std::equal_to<>> texts_;  ///< its elements never move
  std::size_t most_, used_ = 0;
  bool exceeded_ = false;
};

/// An XML entry of a project, read once in pieces. Derived classes receive the elements.
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

/// A document that stays in memory in large part. It is refused when the project keeps more than its bound.
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
