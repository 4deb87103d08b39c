#include "base/compare_text.h"

#include <algorithm>
#include <utility>

namespace rubicon::base {

bool glob_matches(std::string_view pattern, std::string_view text) {
  std::size_t at = 0, read = 0, star = pattern.npos, resume = 0;
  while (read < text.size()) {
    if (at < pattern.size() && pattern[at] == '*') {
      star = at++;
      resume = read;
    } else if (at < pattern.size() && (pattern[at] == '?' || pattern[at] == text[read])) {
      ++at;
      ++read;
    } else if (star != pattern.npos) {
      at = star + 1;
      read = ++resume;  // the last star matches one more character
    } else {
      return false;
    }
  }
  while (at < pattern.size() && pattern[at] == '*') ++at;
  return at == pattern.size();
}

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

namespace {

constexpr std::size_t kMaxWordLength = 100;
constexpr std::size_t kMinStart = 3;

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

bool same(char a, char b) {
  return lower(a) == lower(b);
}

/// Maximum edit distance of a misspelling.
std::size_t most_slips(std::size_t length) {
  if (length <= 5) return 1;
  return length <= 8 ? 2 : 3;
}

bool begins_with(std::string_view text, std::string_view start) {
  return text.size() >= start.size() && std::equal(start.begin(), start.end(), text.begin(), same);
}

}  // namespace

std::size_t edit_distance(std::string_view a, std::string_view b) {
  // Three rows of the table suffice: a swap looks two rows back.
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), now(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      now[j] = std::min({last[j] + 1, now[j - 1] + 1, last[j - 1] + (same(a[i - 1], b[j - 1]) ? 0 : 1)});
      const bool swapped = i > 1 && j > 1 && same(a[i - 1], b[j - 2]) && same(a[i - 2], b[j - 1]);
      if (swapped) now[j] = std::min(now[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, now);
  }
  return last[b.size()];
}

std::vector<std::string> nearest(std::string_view word, const std::vector<std::string>& candidates, std::size_t most) {
  if (word.empty() || word.size() > kMaxWordLength) return {};
  const auto slips = most_slips(word.size());
  std::vector<std::pair<std::size_t, const std::string*>> near;
  for (const auto& candidate : candidates) {
    const auto gap = std::max(candidate.size(), word.size()) - std::min(candidate.size(), word.size());
    const auto distance = gap > slips ? slips + 1 : edit_distance(word, candidate);
    const bool start = word.size() >= kMinStart && begins_with(candidate, word);
    if (distance <= slips || start) near.emplace_back(distance, &candidate);
  }
  std::stable_sort(near.begin(), near.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> found;
  for (const auto& [distance, candidate] : near) {
    if (found.size() >= most) break;
    if (std::find(found.begin(), found.end(), *candidate) == found.end()) found.push_back(*candidate);
  }
  return found;
}

std::string did_you_mean(std::string_view word, const std::vector<std::string>& candidates) {
  if (std::find(candidates.begin(), candidates.end(), word) != candidates.end()) return {};
  const auto near = nearest(word, candidates);
  std::string text;
  for (std::size_t i = 0; i < near.size(); ++i) {
    const char* before = i == 0 ? "did you mean " : i + 1 == near.size() ? " or " : ", ";
    text += before + ("'" + near[i] + "'");
  }
  return text.empty() ? text : text + "?";
}

}  // namespace rubicon::base
