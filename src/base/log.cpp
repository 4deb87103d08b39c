#include "base/log.h"

#include <algorithm>
#include <cctype>
#include <functional>
#include <utility>

namespace rubicon::base {

namespace {
constexpr std::size_t kMaxSubjects = 1024;
/// Bytes. Others may have chosen a longer one: a hash stands for its end.
constexpr std::size_t kMaxSubject = 200;

std::string name_of(const std::string& subject) {
  if (subject.size() <= kMaxSubject) return subject;
  return subject.substr(0, kMaxSubject) + std::to_string(std::hash<std::string>()(subject));
}
}  // namespace

bool RateLimit::allow(const std::string& subject, SteadyTime now) {
  auto name = name_of(subject);
  if (now - cleaned_ >= period_) {
    std::erase_if(last_, [&](const auto& one) { return now - one.second >= period_; });
    cleaned_ = now;
  }
  if (last_.size() >= kMaxSubjects && !last_.contains(name)) name.clear();
  const auto [it, fresh] = last_.try_emplace(name, now);
  if (!fresh && now - it->second < period_) {
    ++swallowed_;
    return false;
  }
  it->second = now;
  return true;
}

namespace {

constexpr std::string_view kSecretWords[] = {"password", "passwd", "passphrase", "secret", "token", "credential"};
constexpr std::string_view kEndOfValue = " \t\r\n,;'\"()[]{}<>";
constexpr std::string_view kBearer = "Bearer";

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

bool in_name(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_' || c == '.';
}

/// Length of the value at the beginning of the text: quoted, or up to what ends a word.
std::size_t length_of_value(std::string_view text) {
  if (text.empty()) return 0;
  if (text.front() == '"' || text.front() == '\'') {
    const auto end = text.find(text.front(), 1);
    return end == text.npos ? text.size() : end + 1;
  }
  return std::min(text.find_first_of(kEndOfValue), text.size());
}

/// Length of `=`, `:` or `: ` behind a name; 0 = there is none.
std::size_t length_of_sign(std::string_view text) {
  if (text.empty() || (text.front() != '=' && text.front() != ':')) return 0;
  if (text.starts_with("://")) return 0;
  return text.starts_with(": ") || text.starts_with("= ") ? 2 : 1;
}

/// The password in `//user:password@host` begins and ends there; an empty range = there is none.
std::pair<std::size_t, std::size_t> password_in_url(std::string_view authority) {
  const auto end = std::min(authority.find_first_of(" \t\r\n/?#,\"'"), authority.size());
  const auto at = authority.substr(0, end).rfind('@');
  const auto colon = authority.substr(0, end).find(':');
  if (at == authority.npos || colon == authority.npos || colon > at) return {0, 0};
  return {colon + 1, at};
}

}  // namespace

bool names_secret(std::string_view option) {
  const auto name = lower(option);
  if (name.ends_with("-file") || name.ends_with("-env")) return false;
  if (name == "key" || name.ends_with("-key") || name.ends_with("_key") || name.ends_with(".key")) return true;
  return std::any_of(std::begin(kSecretWords), std::end(kSecretWords),
                     [&](std::string_view word) { return name.find(word) != name.npos; });
}

std::string masked(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    if (text.starts_with("://")) {
      const auto [begin, end] = password_in_url(text.substr(3));
      out += text.substr(0, 3 + begin);
      if (end > begin) out += kMasked;
      text.remove_prefix(3 + end);
      continue;
    }
    const auto name =
        text.substr(0, static_cast<std::size_t>(std::find_if_not(text.begin(), text.end(), in_name) - text.begin()));
    if (name.empty()) {
      out += text.front();
      text.remove_prefix(1);
      continue;
    }
    out += name;
    text.remove_prefix(name.size());
    auto sign = names_secret(name) ? length_of_sign(text) : 0;
    if (sign == 0 && name == kBearer && text.starts_with(' ')) sign = 1;
    if (sign == 0 || length_of_value(text.substr(sign)) == 0) continue;
    out += text.substr(0, sign);
    out += kMasked;
    text.remove_prefix(sign + length_of_value(text.substr(sign)));
  }
  return out;
}

}  // namespace rubicon::base
