#include "networks/salad/properties_reader.h"

#include <algorithm>
#include <optional>

#include "base/text.h"

namespace rubicon::networks::salad {

namespace {

constexpr std::string_view kSpaces = " \t\f";

bool is_blank(char c) {
  return kSpaces.find(c) != kSpaces.npos;
}

/// Splits a text into lines, which end in LF, CR or CR LF.
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {}

  bool next(std::string_view& line) {
    if (text_.empty()) return false;
    ++number_;
    const auto end = std::min(text_.find_first_of("\r\n"), text_.size());
    line = text_.substr(0, end);
    const bool two = text_.substr(end).starts_with("\r\n");
    text_.remove_prefix(std::min(end + (two ? 2 : 1), text_.size()));
    return true;
  }
  int number() const { return number_; }

 private:
  std::string_view text_;
  int number_ = 0;
};

std::string_view without_leading_blanks(std::string_view line) {
  const auto first = line.find_first_not_of(kSpaces);
  return first == line.npos ? std::string_view() : line.substr(first);
}

/// An odd number of backslashes at the end: the next line continues this one.
bool continues(std::string_view line) {
  std::size_t count = 0;
  while (count < line.size() && line[line.size() - 1 - count] == '\\') ++count;
  return count % 2 == 1;
}

/// The key ends at the first `=`, `:` or blank that has no backslash before it.
std::size_t end_of_key(std::string_view line) {
  std::size_t at = 0;
  for (; at < line.size(); ++at) {
    if (line[at] == '\\') {
      ++at;
    } else if (line[at] == '=' || line[at] == ':' || is_blank(line[at])) {
      break;
    }
  }
  return std::min(at, line.size());
}

std::optional<char32_t> hex4(std::string_view digits) {
  const auto unit = digits.size() == 4 ? base::parse_hex_number<std::uint16_t>(digits) : std::nullopt;
  return unit ? std::optional<char32_t>(*unit) : std::nullopt;
}

/// Writes UTF-16 units as UTF-8; half of a surrogate pair becomes the replacement character.
class Utf8 {
 public:
  explicit Utf8(std::string& out) : out_(out) {}
  ~Utf8() { end_pair(); }
  Utf8(const Utf8&) = delete;
  Utf8& operator=(const Utf8&) = delete;

  void put(char32_t unit) {
    const bool low = unit >= 0xdc00 && unit <= 0xdfff;
    if (high_ != 0 && low) {
      base::append_utf8(0x10000 + ((high_ - 0xd800) << 10U) + (unit - 0xdc00), out_);
      high_ = 0;
      return;
    }
    end_pair();
    if (unit >= 0xd800 && unit <= 0xdbff) {
      high_ = unit;
    } else {
      base::append_utf8(unit, out_);
    }
  }

 private:
  void end_pair() {
    if (high_ != 0) base::append_utf8(high_, out_);
    high_ = 0;
  }
  std::string& out_;
  char32_t high_ = 0;
};

char32_t unescaped(char c) {
  switch (c) {
    case 't': return '\t';
    case 'n': return '\n';
    case 'r': return '\r';
    case 'f': return '\f';
    default: return static_cast<unsigned char>(c);
  }
}

std::string unescape(std::string_view text, std::string& fault) {
  std::string out;
  Utf8 utf8(out);
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text[at] != '\\') {
      utf8.put(static_cast<unsigned char>(text[at]));
      continue;
    }
    if (++at == text.size()) break;
    if (text[at] != 'u') {
      utf8.put(unescaped(text[at]));
      continue;
    }
    const auto unit = hex4(text.substr(at + 1, 4));
    if (!unit) {
      fault = "\\u is not followed by four hexadecimal digits";
      break;
    }
    utf8.put(*unit);
    at += 4;
  }
  return out;
}

Property property_of(std::string_view line, int number) {
  Property property;
  property.line = number;
  const auto end = end_of_key(line);
  property.key = unescape(line.substr(0, end), property.fault);
  auto value = without_leading_blanks(line.substr(end));
  if (value.starts_with('=') || value.starts_with(':')) value = without_leading_blanks(value.substr(1));
  property.value = unescape(value, property.fault);
  return property;
}

}  // namespace

std::vector<Property> read_properties(std::string_view text) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);  // Java does not skip it, but some editors write it
  std::vector<Property> properties;
  Lines lines(text);
  for (std::string_view line; lines.next(line);) {
    line = without_leading_blanks(line);
    if (line.empty() || line[0] == '#' || line[0] == '!') continue;
    const int number = lines.number();
    std::string whole;
    bool more = continues(line);
    whole = line.substr(0, line.size() - (more ? 1 : 0));
    while (more && lines.next(line)) {
      line = without_leading_blanks(line);
      more = continues(line);
      whole += line.substr(0, line.size() - (more ? 1 : 0));
    }
    properties.push_back(property_of(whole, number));
  }
  return properties;
}

}  // namespace rubicon::networks::salad
