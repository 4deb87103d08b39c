#include "base/nearest.h"

#include <algorithm>
#include <utility>

namespace rubicon::base {

namespace {

constexpr std::size_t kLongestWord = 100;
constexpr std::size_t kShortestStart = 3;

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
  if (word.empty() || word.size() > kLongestWord) return {};
  const auto slips = most_slips(word.size());
  std::vector<std::pair<std::size_t, const std::string*>> near;
  for (const auto& candidate : candidates) {
    const auto gap = std::max(candidate.size(), word.size()) - std::min(candidate.size(), word.size());
    const auto distance = gap > slips ? slips + 1 : edit_distance(word, candidate);
    const bool start = word.size() >= kShortestStart && begins_with(candidate, word);
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
