#pragma once

#include <openssl/crypto.h>

#include <string>
#include <string_view>
#include <utility>

namespace rubicon::trust {

/// A text that only its owner may see: a key in PEM, a pass phrase. Overwritten at its end; has no output operator.
class SecretText {
 public:
  SecretText() = default;
  /// Takes the text; the string that is given is empty afterwards.
  explicit SecretText(std::string&& text) : text_(text) { wipe(text); }
  SecretText(SecretText&& other) noexcept : text_(other.text_) { wipe(other.text_); }
  SecretText& operator=(SecretText&& other) noexcept {
    if (this == &other) return *this;
    wipe(text_);
    text_ = other.text_;
    wipe(other.text_);
    return *this;
  }
  SecretText(const SecretText&) = delete;
  SecretText& operator=(const SecretText&) = delete;
  ~SecretText() { wipe(text_); }

  std::string_view view() const { return text_; }
  bool empty() const { return text_.empty(); }

 private:
  static void wipe(std::string& text) {
    OPENSSL_cleanse(text.data(), text.size());
    text.clear();
  }

  std::string text_;
};

/// Call this before a program reads a key. From then on this process writes no core file, which would contain the key,
/// and no other process of its user can read its memory. A library does not decide that for its program.
void keep_memory_private();

}  // namespace rubicon::trust
