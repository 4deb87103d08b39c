#include "base/natural_order.h"

#include <algorithm>

namespace rubicon::base {

namespace {

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

bool is_word(char c) {
  return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

bool is_hex_digit(char c) {
  return is_digit(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F');
}

/// `00124b0010000000`, with or without `0x`.
bool is_ieee_address(std::string_view word) {
  if (word.starts_with("0x")) word.remove_prefix(2);
  return word.size() == 16 && std::all_of(word.begin(), word.end(), is_hex_digit);
}

/// What is compared as one; numbers without leading zeros.
struct Part {
  enum class Kind : unsigned char { kNumber, kAddress, kCharacter };
  Kind kind = Kind::kCharacter;
  std::string_view text;
};

/// Takes a text apart, from its front.
class Parts {
 public:
  explicit Parts(std::string_view text) : rest_(text) {}
  bool empty() const { return rest_.empty(); }

  Part take() {
    const bool begins = !in_word_;
    in_word_ = is_word(rest_.front());
    const auto word = begins ? length_of(is_word) : 0;
    if (is_ieee_address(rest_.substr(0, word))) return {Part::Kind::kAddress, take(word)};
    if (!is_digit(rest_.front())) return {Part::Kind::kCharacter, take(1)};
    auto number = take(length_of(is_digit));
    number.remove_prefix(std::min(number.find_first_not_of('0'), number.size()));
    return {Part::Kind::kNumber, number};
  }

 private:
  std::size_t length_of(bool (*belongs)(char)) const {
    return static_cast<std::size_t>(std::find_if_not(rest_.begin(), rest_.end(), belongs) - rest_.begin());
  }
  std::string_view take(std::size_t length) {
    const auto part = rest_.substr(0, length);
    rest_.remove_prefix(length);
    return part;
  }

  std::string_view rest_;
  bool in_word_ = false;
};

/// Numbers and addresses stand where digits stand among the characters.
unsigned char place_of(const Part& part) {
  return static_cast<unsigned char>(part.kind == Part::Kind::kCharacter ? part.text.front() : '0');
}

/// Negative: a comes first.
int compare(const Part& a, const Part& b) {
  if (place_of(a) != place_of(b)) return place_of(a) < place_of(b) ? -1 : 1;
  if (a.kind != b.kind) return a.kind < b.kind ? -1 : 1;
  if (a.kind == Part::Kind::kNumber && a.text.size() != b.text.size()) return a.text.size() < b.text.size() ? -1 : 1;
  return a.text.compare(b.text);
}

}  // namespace

bool natural_less(std::string_view a, std::string_view b) {
  Parts of_a(a), of_b(b);
  while (!of_a.empty() && !of_b.empty()) {
    if (const int order = compare(of_a.take(), of_b.take()); order != 0) return order < 0;
  }
  if (of_a.empty() && of_b.empty()) return a < b;  // 07 and 7
  return of_a.empty();
}

}  // namespace rubicon::base
