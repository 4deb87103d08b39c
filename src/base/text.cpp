#include "base/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>

namespace rubicon::base {

std::string resolve_path(std::string_view directory, std::string_view path) {
  return (std::filesystem::path(directory) / path).string();
}

void append_arguments(std::string& out, fmt::string_view format, fmt::format_args arguments) {
  fmt::vformat_to(std::back_inserter(out), format, arguments);
}

namespace {

/// Length of the sequence and the smallest character that needs it (RFC 3629).
struct Lead {
  std::size_t length = 0;
  char32_t bits = 0;
  char32_t smallest = 0;
};

Lead lead_of(unsigned char byte) {
  if (byte < 0x80) return {1, byte, 0};
  if ((byte & 0xe0) == 0xc0) return {2, byte & 0x1fU, 0x80};
  if ((byte & 0xf0) == 0xe0) return {3, byte & 0x0fU, 0x800};
  if ((byte & 0xf8) == 0xf0) return {4, byte & 0x07U, 0x10000};
  return {};
}

bool is_character(char32_t code) {
  const bool surrogate = code >= 0xd800 && code < 0xe000;
  return code <= 0x10ffff && !surrogate;
}

std::optional<char32_t> character_at(std::string_view text, const Lead& lead) {
  if (lead.length == 0 || lead.length > text.size()) return std::nullopt;
  char32_t character = lead.bits;
  for (std::size_t i = 1; i < lead.length; ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if ((byte & 0xc0) != 0x80) return std::nullopt;
    character = character << 6 | (byte & 0x3fU);
  }
  if (character < lead.smallest || !is_character(character)) return std::nullopt;
  return character;
}

}  // namespace

std::optional<char32_t> take_utf8(std::string_view& text) {
  if (text.empty()) return std::nullopt;
  const auto lead = lead_of(static_cast<unsigned char>(text[0]));
  const auto character = character_at(text, lead);
  text.remove_prefix(character ? lead.length : 1);
  return character;
}

void append_utf8(char32_t character, std::string& out) {
  constexpr char32_t kReplacement = 0xfffd;
  if (!is_character(character)) character = kReplacement;
  const auto put_rest = [&](unsigned shift) { out += static_cast<char>(0x80 | (character >> shift & 0x3f)); };
  if (character < 0x80) {
    out += static_cast<char>(character);
    return;
  }
  if (character < 0x800) {
    out += static_cast<char>(0xc0 | character >> 6);
  } else if (character < 0x10000) {
    out += static_cast<char>(0xe0 | character >> 12);
    put_rest(6);
  } else {
    out += static_cast<char>(0xf0 | character >> 18);
    put_rest(12);
    put_rest(6);
  }
  put_rest(0);
}

namespace {

bool continues(char c) {
  return (static_cast<unsigned char>(c) & 0xc0U) == 0x80;
}

bool steers(char32_t code) {
  const auto in = [code](char32_t low, char32_t high) { return code >= low && code <= high; };
  const bool control = code < 0x20 || in(0x7f, 0x9f) || in(0x2028, 0x2029);
  return control || code == 0x061c || in(0x200e, 0x200f) || in(0x202a, 0x202e) || in(0x2066, 0x2069);
}

}  // namespace

std::size_t utf8_prefix(std::string_view text) {
  for (auto rest = text; !rest.empty();) {
    const auto at = text.size() - rest.size();
    if (!take_utf8(rest)) return at;
  }
  return text.size();
}

bool is_utf8(std::string_view text) {
  return utf8_prefix(text) == text.size();
}

std::size_t characters(std::string_view text) {
  std::size_t count = 0;
  for (; !text.empty(); ++count) text.remove_prefix(first_character(text).size());
  return count;
}

std::string one_line(std::string_view text) {
  std::string line(text);
  std::replace_if(
      line.begin(), line.end(), [](unsigned char c) { return c < ' '; }, ' ');
  return printable(line);
}

std::string_view first_character(std::string_view text) {
  std::size_t length = std::min<std::size_t>(text.size(), 1);
  while (length < text.size() && continues(text[length])) ++length;
  return text.substr(0, length);
}

std::string fitted(std::string_view text, std::size_t width) {
  std::string out;
  std::size_t shown = 0;
  for (; !text.empty() && shown < width; ++shown) {
    const auto character = first_character(text);
    auto rest = character;
    const auto code = take_utf8(rest);
    const bool good = code && rest.empty() && !steers(*code);
    good ? out += character : out += '?';
    text.remove_prefix(character.size());
  }
  return out.append(width - shown, ' ');
}

std::string printable(std::string_view text) {
  return fitted(text, characters(text));
}

bool is_nested_deeper(std::string_view json, std::size_t levels) {
  std::size_t depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (quoted && c == '\\') ++i;
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    if (c == '[' || c == '{') ++depth;
    if ((c == ']' || c == '}') && depth > 0) --depth;
    if (depth > levels) return true;
  }
  return false;
}

namespace {

/// The host before the colon, without its brackets; nullopt if the brackets or colons are wrong.
std::optional<std::string> host_in(std::string_view text) {
  if (text.starts_with('[')) {
    if (text.size() < 3 || !text.ends_with(']')) return std::nullopt;
    text = text.substr(1, text.size() - 2);
    if (text.find(':') == text.npos) return std::nullopt;
  } else if (text.find(':') != text.npos) {
    return std::nullopt;
  }
  if (text.find_first_of("[] \t") != text.npos) return std::nullopt;
  return std::string(text);
}

/// Four numbers up to 255.
bool is_ipv4(std::string_view text) {
  for (int part = 0; part < 4; ++part) {
    const auto dot = text.find('.');
    if ((dot == text.npos) != (part == 3) || !parse_number<std::uint8_t>(text.substr(0, dot))) return false;
    text.remove_prefix(dot == text.npos ? text.size() : dot + 1);
  }
  return true;
}

}  // namespace

std::string host_fault(std::string_view text) {
  if (text.empty() || text.find_first_of("/@ \t") != text.npos) return "expected a host name or an address";
  if (text.find_first_not_of("0123456789.") == text.npos && !is_ipv4(text))
    return "is no IPv4 address, expected four numbers from 0 to 255, or a name";
  const auto colon = text.find(':');
  const bool has_port =
      colon != text.npos && colon == text.rfind(':') && text.find_first_not_of("0123456789", colon + 1) == text.npos;
  return has_port ? "names a port too, expected that in 'port'" : "";
}

std::optional<HostPort> parse_host_port(std::string_view text) {
  const auto colon = text.rfind(':');
  if (colon == text.npos) return std::nullopt;
  const auto port = parse_number<std::uint16_t>(text.substr(colon + 1));
  auto host = host_in(text.substr(0, colon));
  if (!port || *port == 0 || !host) return std::nullopt;
  return HostPort{std::move(*host), *port};
}

std::optional<HostPort> parse_host_port(std::string_view text, std::uint16_t default_port) {
  if (auto both = parse_host_port(text)) return both;
  auto host = host_in(text);
  if (!host || host->empty()) return std::nullopt;
  return HostPort{std::move(*host), default_port};
}

}  // namespace rubicon::base
