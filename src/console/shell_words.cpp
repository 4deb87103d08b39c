#include "console/shell_words.h"

#include <fmt/format.h>

#include "base/text.h"

namespace rubicon::console {

std::string_view take_word(std::string_view& rest) {
  const auto begin = rest.find_first_not_of(" \t");
  if (begin == rest.npos) {
    rest = {};
    return {};
  }
  rest.remove_prefix(begin);
  const auto word = rest.substr(0, rest.find_first_of(" \t"));
  rest.remove_prefix(word.size());
  if (!rest.empty()) rest.remove_prefix(1);
  return word;
}

Result<tuples::TupleName> read_name(std::string_view text, OwnerId island) {
  auto pattern = Pattern::parse(text);
  if (!pattern) return fail(pattern.error());
  if (!pattern->exact()) {
    return fail(ErrorCode::kInvalid, fmt::format("{}: expected a key without *", model::quoted(text)));
  }
  return tuples::TupleName{pattern->owner.value_or(island), std::move(pattern->key)};
}

Result<std::optional<std::uint64_t>> take_sequence(std::string_view& word) {
  const auto at = word.find('@');
  if (at == word.npos) return std::nullopt;
  const auto digits = word.substr(at + 1);
  const auto sequence = base::parse_number<std::uint64_t>(digits);
  if (!sequence) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: expected a sequence number behind the @, such as KEY@7", model::quoted(word)));
  }
  word = word.substr(0, at);
  return sequence;
}

}  // namespace rubicon::console
