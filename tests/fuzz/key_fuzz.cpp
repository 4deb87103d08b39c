#include <cstdlib>

#include "base/bytes.h"
#include "base/text.h"
#include "fuzz_target.h"
#include "rubicon/key.hpp"

namespace rubicon::fuzz::key_fuzz {

namespace {

/// Matching by the words of the documentation, part by part.
bool matches_by_parts(const Pattern& pattern, std::string_view key) {
  const auto wanted = model::key_parts(pattern.key);
  const auto parts = model::key_parts(key);
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (wanted[i] == "**") return true;
    if (i >= parts.size() || (wanted[i] != "*" && wanted[i] != parts[i])) return false;
  }
  return wanted.size() == parts.size();
}

void check_any_text(std::string_view text) {
  const auto part = model::to_key_part(text);
  if (part.size() > 64 || !model::check_key(part)) std::abort();
  const auto quoted = model::quoted(text);
  if (base::printable(quoted) != quoted) std::abort();
  if (const auto sound = model::check_key(text); !sound && sound.error().text.empty()) std::abort();
}

}  // namespace

/// Input: a pattern, a newline, a key.
FUZZ_TARGET(key) {
  const auto text = base::as_text({data, size});
  const auto line_end = text.find('\n');
  const auto key = line_end == text.npos ? text : text.substr(line_end + 1);
  check_any_text(text);
  check_any_text(key);
  const auto pattern = Pattern::parse(text.substr(0, line_end));
  if (!pattern) return 0;
  const auto again = Pattern::parse(to_string(*pattern));
  if (!again || !(*again == *pattern)) std::abort();
  if (!model::check_key(key)) return 0;
  const OwnerId owner = pattern->owner.value_or(OwnerId{1});
  if (pattern->matches(owner, key) != matches_by_parts(*pattern, key)) std::abort();
  if (pattern->exact() && pattern->matches(owner, key) != (pattern->key == key)) std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::key_fuzz
