#include "tuples/stored_text.h"

#include <algorithm>
#include <functional>
#include <new>

namespace rubicon::tuples {

StoredText::Block* StoredText::make_block(std::size_t capacity) {
  constexpr std::size_t kHeads = sizeof(Block) + sizeof(void*), kStep = 16;  // malloc's head and step: no rest is left
  capacity = (capacity + kHeads + kStep - 1) / kStep * kStep - kHeads;
  return new (::operator new(sizeof(Block) + capacity)) Block{1, static_cast<std::uint32_t>(capacity)};
}

void StoredText::release(Block* block) {
  if (--block->uses == 0) ::operator delete(block);
}

void StoredText::set_block(Block* block, std::size_t size) {
  const auto size32 = static_cast<std::uint32_t>(size);
  std::memcpy(bytes_, &block, sizeof block);
  std::memcpy(bytes_ + sizeof block, &size32, sizeof size32);
  bytes_[kInside] = static_cast<char>(kInBlock);
}

void StoredText::set_inside(std::string_view text) {
  std::memmove(bytes_, text.data(), text.size());
  bytes_[kInside] = static_cast<char>(text.size());
}

void StoredText::assign(std::string_view text) {
  auto* const before = in_block() ? block() : nullptr;
  if (text.empty()) {
    forget();
  } else if (text.size() <= kInside) {
    set_inside(text);
  } else if (has_room(text.size()) && before->capacity <= 2 * text.size()) {
    std::memmove(before->text(), text.data(), text.size());
    return set_block(before, text.size());
  } else {
    auto* const made = make_block(text.size());
    std::memcpy(made->text(), text.data(), text.size());
    set_block(made, text.size());
  }
  if (before) release(before);
}

void StoredText::append(std::string_view text) {
  const auto present = size(), all = present + text.size();
  if (!in_block() && all <= kInside) {
    std::memmove(bytes_ + present, text.data(), text.size());
    bytes_[kInside] = static_cast<char>(all);
    return;
  }
  if (has_room(all)) {
    std::memmove(block()->text() + present, text.data(), text.size());
    return set_block(block(), all);
  }
  auto* const made = make_block(std::max(all, present + present / 2));
  std::memcpy(made->text(), view().data(), present);
  std::memcpy(made->text() + present, text.data(), text.size());
  release();
  set_block(made, all);
}

void SharedTexts::assign(StoredText& to, std::string_view text) {
  if (text.size() <= StoredText::kInside || text.size() > kMaxLength) return to.assign(text);
  auto& known = known_[std::hash<std::string_view>{}(text) % kPlaces];
  if (known.view() != text) {
    known = {};  // its block may be written to again
    known.assign(text);
  }
  to = known;
}

}  // namespace rubicon::tuples
