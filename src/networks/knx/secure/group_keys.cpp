#include "networks/knx/secure/group_keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "networks/knx/secure/passwords.h"

namespace rubicon::networks::knx::secure {

namespace {

constexpr std::string_view kBlanks = " \t\r";

/// Takes the next word of a line; empty at its end.
std::string_view next_word(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
  const auto word = line.substr(0, line.find_first_of(kBlanks));
  line.remove_prefix(word.size());
  return word;
}

std::optional<Key> key_of(std::string_view digits) {
  auto bytes = base::from_hex(digits);
  auto key = bytes ? Key::from(*bytes) : Result<Key>(fail(bytes.error()));
  if (bytes) wipe(*bytes);
  return key ? std::optional(std::move(*key)) : std::nullopt;
}

/// What is wrong with a line; no word of it is repeated, because each may be a key.
class Lines {
 public:
  Result<void> take(std::string_view line) {
    ++number_;
    line = line.substr(0, line.find('#'));
    const auto first = next_word(line);
    if (first.empty()) return {};
    const auto group = wire::parse_group(first);
    if (!group) return wrong("its first word is not a group address");
    auto key = key_of(next_word(line));
    if (!key) return wrong("the address is not followed by a key of 32 hexadecimal digits");
    auto& entry = keys_.groups[*group];
    if (entry.key) return wrong(fmt::format("{} has a key in a line before", to_string(*group)));
    entry.key = std::move(key);
    return take_senders(line, entry);
  }

  std::size_t number() const { return number_; }
  GroupKeys take_keys() { return std::move(keys_); }

 private:
  Result<void> take_senders(std::string_view line, GroupKey& entry) {
    const auto word = next_word(line);
    entry.any_sender = word.empty();
    if (word.empty()) return {};
    if (word != "sender") return wrong("the key is followed by something other than `sender`");
    for (auto text = next_word(line); !text.empty(); text = next_word(line)) {
      const auto sender = wire::parse_individual(text);
      if (!sender || wire::number(*sender) == 0) return wrong("after `sender` there are not only individual addresses");
      entry.senders.insert(*sender);
    }
    return entry.senders.empty() ? wrong("`sender` is not followed by an individual address") : Result<void>();
  }

  Result<void> wrong(std::string_view what) const {
    return fail(ErrorCode::kInvalid,
                fmt::format("line {}: {}; expected `1/2/7 KEY` or `1/2/7 KEY sender 1.1.5 1.1.6`", number_, what));
  }

  GroupKeys keys_;
  std::size_t number_ = 0;
};

}  // namespace

Result<GroupKeys> parse_group_keys(std::string_view text) {
  Lines lines;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    if (auto taken = lines.take(text.substr(0, end)); !taken) return fail(taken.error());
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  auto keys = lines.take_keys();
  if (keys.groups.empty()) return fail(ErrorCode::kInvalid, "has no key: expected lines like `1/2/7 KEY`");
  return keys;
}

Result<GroupKeys> read_group_keys_file(transport::Transports& transports, const std::string& path) {
  const auto content = read_private_file(transports, path, kMaxGroupKeysBytes, "these keys");
  if (!content) return fail(content.error());
  auto keys = parse_group_keys(content->text());
  if (!keys) return fail(keys.error().code, fmt::format("{}: {}", path, keys.error().text));
  return keys;
}

}  // namespace rubicon::networks::knx::secure
