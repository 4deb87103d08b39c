#pragma once

#include <memory>
#include <string>
#include <utility>

namespace rubicon::proxy {

/// A text that most devices and points do not have; takes eight bytes while it is empty.
class RareText {
 public:
  RareText() = default;
  RareText& operator=(std::string text) {
    text_ = text.empty() ? nullptr : std::make_unique<const std::string>(std::move(text));
    return *this;
  }

  const std::string& text() const {
    static const std::string kEmpty;
    return text_ ? *text_ : kEmpty;
  }
  bool empty() const { return !text_; }
  void clear() { text_.reset(); }

  friend bool operator==(const RareText& one, const std::string& other) { return one.text() == other; }

 private:
  std::unique_ptr<const std::string> text_;
};

}  // namespace rubicon::proxy
