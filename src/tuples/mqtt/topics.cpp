#include "tuples/mqtt/topics.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/text.h"

namespace rubicon::tuples::mqtt {

namespace {

constexpr std::size_t kTokenDigits = 12;
/// Stands where a part of presence has its digit.
constexpr std::string_view kDocuments = "p/realm/";
/// Names that mean others in rules and topics.
constexpr std::string_view kProbe = "-probe-";
constexpr std::array<std::string_view, 5> kTaken{kProbe, "peis", "lan", "everybody", ""};

bool is_token(std::string_view text) {
  return text.size() == kTokenDigits &&
         std::all_of(text.begin(), text.end(), [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

bool is_user(std::string_view text) {
  return text == kAnonymous || check_user(text).has_value();
}

/// Takes the next level; false: there is none.
bool next_level(std::string_view& rest, std::string_view& level) {
  if (rest.data() == nullptr) return false;
  const auto end = rest.find('/');
  level = rest.substr(0, end);
  rest = end == rest.npos ? std::string_view() : rest.substr(end + 1);
  return true;
}

bool next_line(std::string_view& rest, Line& line) {
  std::string_view user, token;
  if (!next_level(rest, user) || !next_level(rest, token) || !is_user(user) || !is_token(token)) return false;
  line = {std::string(user), std::string(token)};
  return true;
}

}  // namespace

Result<void> check_user(std::string_view user) {
  if (user.size() > kMaxUser)
    return fail(ErrorCode::kInvalid,
                fmt::format("the user name has {} bytes, expected at most {}", user.size(), kMaxUser));
  if (user == kAnonymous || std::find(kTaken.begin(), kTaken.end(), user) != kTaken.end())
    return fail(ErrorCode::kInvalid, fmt::format("'{}' is not a user name: rules and topics mean others by it", user));
  const auto bad = std::find_if(user.begin(), user.end(), [](char c) {
    return c == '/' || c == '+' || c == '#' || c == ':' || static_cast<unsigned char>(c) < 0x20;
  });
  if (bad == user.end()) return {};
  return fail(ErrorCode::kInvalid, fmt::format("the user name '{}' has a '{}', expected none of / + # :", user, *bad));
}

bool is_space(std::string_view name) {
  return !name.empty() && name.size() <= kMaxUser && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '.' ||
           c == '-';
  });
}

Topics::Topics(std::string_view space) : root_(fmt::format("rubicon-space/1/{}/", space)) {}

std::string Topics::line(const Line& line) const {
  return fmt::format("{}p/{}/{}/{}", root_, line.token.back(), line.user, line.token);
}

std::string Topics::component(const Line& line, OwnerId id) const {
  return fmt::format("{}/{}", this->line(line), number(id));
}

std::string Topics::presence_filter(char shard) const {
  return fmt::format("{}p/{}/#", root_, shard);
}

std::string Topics::component_filter(OwnerId id) const {
  return fmt::format("{}p/+/+/+/{}", root_, number(id));
}

std::string Topics::line_filter(const Line& line) const {
  return this->line(line) + "/#";
}

std::string Topics::user_filter(std::string_view user) const {
  return fmt::format("{}p/+/{}/#", root_, user);
}

std::string Topics::inbox(const Line& to, const Line& from) const {
  return fmt::format("{}to/{}/{}/{}/{}", root_, to.user, to.token, from.user, from.token);
}

std::string Topics::inbox_filter(const Line& own) const {
  return fmt::format("{}to/{}/{}/+/+", root_, own.user, own.token);
}

std::string Topics::inbox_probe(const Line& own) const {
  return inbox(own, {std::string(kProbe), own.token});
}

/// Not in a part that others read.
std::string Topics::presence_probe(const Line& own) const {
  return fmt::format("{}p/probe/{}/{}", root_, kProbe, own.token);
}

std::string Topics::document(std::string_view user) const {
  return fmt::format("{}{}{}", root_, kDocuments, user);
}

std::string Topics::document_filter() const {
  return document("+");
}

std::optional<std::string> Topics::user_of_document(std::string_view topic) const {
  if (!topic.starts_with(root_) || !topic.substr(root_.size()).starts_with(kDocuments)) return {};
  const auto user = topic.substr(root_.size() + kDocuments.size());
  return is_user(user) ? std::optional(std::string(user)) : std::nullopt;
}

Topics::Parsed Topics::parse(std::string_view topic) const {
  if (!topic.starts_with(root_)) return {};
  auto rest = topic.substr(root_.size());
  std::string_view kind, shard, id;
  if (!next_level(rest, kind)) return {};
  if (kind == "to") {
    Inbox inbox;
    if (!next_line(rest, inbox.to) || !next_line(rest, inbox.from) || rest.data() != nullptr) return {};
    return inbox;
  }
  Presence presence;
  if (kind != "p" || !next_level(rest, shard) || !next_line(rest, presence.line)) return {};
  if (shard.size() != 1 || shard.front() != presence.line.token.back()) return {};
  if (!next_level(rest, id)) return presence;
  const auto number = base::parse_number<std::uint32_t>(id);
  if (!number || rest.data() != nullptr || std::to_string(*number) != id) return {};
  presence.component = OwnerId(*number);
  return presence;
}

}  // namespace rubicon::tuples::mqtt
