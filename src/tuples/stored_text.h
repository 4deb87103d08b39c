#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <utility>
#include <vector>

namespace rubicon::tuples {

/// The value of a stored tuple, in 16 bytes: a short text is inside, a longer one in a block on the heap. Copies share
/// the block until one of them changes. Copies belong to one thread.
class StoredText {
 public:
  static constexpr std::size_t kInside = 15;

  StoredText() = default;
  StoredText(const StoredText& other) { take(other, true); }
  StoredText(StoredText&& other) noexcept {
    take(other, false);
    other.forget();
  }
  StoredText& operator=(StoredText other) noexcept {
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  ~StoredText() { release(); }

  std::size_t size() const { return in_block() ? read<std::uint32_t>(sizeof(Block*)) : mark(); }
  std::string_view view() const { return {in_block() ? block()->text() : bytes_, size()}; }
  operator std::string_view() const { return view(); }  // NOLINT(google-explicit-constructor): it is a text

  /// `text` may be a part of this one; below 4 GiB, as for append().
  void assign(std::string_view text);
  void append(std::string_view text);

 private:
  struct Block {
    std::uint32_t uses, capacity;
    char* text() { return reinterpret_cast<char*>(this + 1); }
  };
  static constexpr std::uint8_t kInBlock = kInside + 1;

  /// The size of a text inside, or kInBlock.
  std::uint8_t mark() const { return static_cast<std::uint8_t>(bytes_[kInside]); }
  bool in_block() const { return mark() == kInBlock; }
  template <class T>
  T read(std::size_t at) const {
    T value;
    std::memcpy(&value, bytes_ + at, sizeof value);
    return value;
  }
  Block* block() const { return read<Block*>(0); }
  void take(const StoredText& other, bool shares) {
    std::memcpy(bytes_, other.bytes_, sizeof bytes_);
    if (shares && in_block()) ++block()->uses;
  }
  void forget() { bytes_[kInside] = 0; }
  void release() {
    if (in_block()) release(block());
  }
  static void release(Block* block);
  static Block* make_block(std::size_t capacity);
  bool has_room(std::size_t size) const { return in_block() && block()->uses == 1 && block()->capacity >= size; }
  void set_block(Block* block, std::size_t size);
  void set_inside(std::string_view text);

  alignas(8) char bytes_[kInside + 1] = {};  ///< the text and its mark; or Block*, size, mark
};

/// Values of tuples that are created: where one equals a value of before, both share a block, as the descriptions of
/// thousands of points of one kind. Remembers a bounded number of texts.
class SharedTexts {
 public:
  static constexpr std::size_t kPlaces = 512;
  /// In bytes; longer texts are not remembered.
  static constexpr std::size_t kMaxLength = 1024;

  void assign(StoredText& to, std::string_view text);

 private:
  std::vector<StoredText> known_ = std::vector<StoredText>(kPlaces);  ///< by the hash of the text
};

}  // namespace rubicon::tuples
