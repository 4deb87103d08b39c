#include "networks/knx/project/document.h"

#include <fmt/format.h>

#include "base/text.h"
#include "networks/knx/groups/encoding.h"

namespace rubicon::networks::knx::project {

namespace {

/// Of an element of the set besides its bytes: the element, its bucket and the overhead of the heap.
constexpr std::size_t kOverhead = 96;

}  // namespace

std::string_view KeptTexts::keep(std::string_view text) {
  if (text.empty()) return {};
  if (const auto found = texts_.find(text); found != texts_.end()) return *found;
  if (!charge(text.size() + kOverhead)) return {};
  return *texts_.emplace(text).first;
}

bool KeptTexts::charge(std::size_t bytes) {
  if (exceeded_ || bytes > most_ - used_) {
    exceeded_ = true;
    return false;
  }
  used_ += bytes;
  return true;
}

std::string KeptTexts::why() const {
  return fmt::format("more than {} bytes of names and texts: file refused, nothing imported", most_);
}

Result<void> Document::read(const Archive& archive, const Archive::Entry& entry, const secure::Secret* password) {
  const auto wrong = [&](const Error& error) {
    return fail(ErrorCode::kInvalid, fmt::format("{}:{}: {}", base::printable(entry.name), parser_.line(), error.text));
  };
  auto read = archive.read(entry, password, [&](std::string_view piece) -> Result<bool> {
    if (auto fed = parser_.feed(piece); !fed) return wrong(fed.error());
    return !parser_.has_enough();
  });
  if (!read) return read;
  if (auto finished = parser_.finish(); !finished) return wrong(finished.error());
  return {};
}

Result<void> Document::read_text(std::string_view text) {
  auto fed = parser_.feed(text);
  return fed ? parser_.finish() : fed;
}

std::string_view KeepingDocument::keep(std::string_view text) {
  const auto kept = texts_.keep(text);
  if (texts_.is_exceeded()) parser().refuse(texts_.why());
  return kept;
}

std::string_view KeepingDocument::keep(const xml::Attributes& attributes, std::string_view name) {
  return keep(short_text(attributes, name));
}

bool KeepingDocument::charge(std::size_t bytes) {
  if (texts_.charge(bytes)) return true;
  parser().refuse(texts_.why());
  return false;
}

std::optional<bool> enabled(const xml::Attributes& attributes, std::string_view name) {
  const auto value = attributes.text(name);
  if (value.empty()) return std::nullopt;
  return value == "Enabled" || value == "true" || value == "1";
}

std::string short_text(const xml::Attributes& attributes, std::string_view name) {
  return groups::clean_text(attributes.text(name), kMaxText);
}

}  // namespace rubicon::networks::knx::project
