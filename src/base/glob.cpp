#include "base/glob.h"

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
      read = ++resume;  // the last star takes one more
    } else {
      return false;
    }
  }
  while (at < pattern.size() && pattern[at] == '*') ++at;
  return at == pattern.size();
}

}  // namespace rubicon::base
