#include "networks/knx/groups/encoding.h"

#include <algorithm>
#include <array>

#include "base/text.h"

namespace rubicon::networks::knx::groups {

namespace {

constexpr std::string_view kUtf32 = "text in UTF-32";
/// Bytes that show the form of a text.
constexpr std::size_t kExamined = 1024;

bool is_ascii(std::string_view bytes) {
  for (const char c : bytes) {
    if ((static_cast<std::uint8_t>(c) & 0x80) != 0) return false;
  }
  return true;
}

}  // namespace

Encoding encoding_of(std::string_view bytes) {
  if (base::is_utf8(bytes)) return Encoding::kUtf8;
  if (bytes.starts_with(kUtf8Mark)) return Encoding::kMixed;
  while (!bytes.empty()) {
    const auto end = std::min(bytes.find('\n'), bytes.size() - 1);
    const auto line = bytes.substr(0, end + 1);
    if (!is_ascii(line) && base::is_utf8(line)) return Encoding::kMixed;
    bytes.remove_prefix(end + 1);
  }
  return Encoding::kWindows1252;
}

std::optional<Wide> utf16_of(std::string_view bytes) {
  if (name_of_foreign(bytes.substr(0, 4)) == kUtf32) return {};
  if (bytes.starts_with("\xff\xfe")) return Wide::kLittle;
  if (bytes.starts_with("\xfe\xff")) return Wide::kBig;
  // An export is mostly ASCII, whose characters have a zero byte; no other encoding of text has any.
  const auto first = bytes.substr(0, std::min(bytes.size(), kExamined) & ~std::size_t{1});
  std::array<std::size_t, 2> zeros{};
  for (std::size_t i = 0; i < first.size(); ++i) zeros[i % 2] += first[i] == '\0' ? 1U : 0U;
  if (zeros[0] == 0 && zeros[1] * 4 > first.size()) return Wide::kLittle;
  if (zeros[1] == 0 && zeros[0] * 4 > first.size()) return Wide::kBig;
  return {};
}

Result<std::string> from_utf16(std::string_view bytes, Wide form) {
  if (bytes.size() % 2 != 0) return fail(ErrorCode::kInvalid, "UTF-16 with an odd number of bytes: the file is cut");
  const auto unit = [&](std::size_t at) {
    const auto one = static_cast<std::uint8_t>(bytes[at]), two = static_cast<std::uint8_t>(bytes[at + 1]);
    return static_cast<char32_t>(form == Wide::kBig ? one << 8 | two : two << 8 | one);
  };
  std::string out;
  out.reserve(bytes.size() * 5 / 8);
  for (std::size_t at = 0; at < bytes.size(); at += 2) {
    auto character = unit(at);
    if (character == 0xfeff && at == 0) continue;
    const bool high = character >= 0xd800 && character < 0xdc00 && at + 3 < bytes.size();
    if (const auto low = high ? unit(at + 2) : char32_t{0}; low >= 0xdc00 && low < 0xe000) {
      character = 0x10000 + ((character - 0xd800) << 10) + (low - 0xdc00);
      at += 2;
    }
    base::append_utf8(character, out);
  }
  return out;
}

std::string_view name_of_foreign(std::string_view bytes) {
  using namespace std::string_view_literals;
  struct Head {
    std::string_view bytes, name;
  };
  static constexpr std::array kHeads{Head{"\xff\xfe\0\0"sv, kUtf32},
                                     Head{"\0\0\xfe\xff"sv, kUtf32},
                                     Head{"PK\x03\x04"sv, "an archive (.knxproj of a project, .xlsx of Excel)"},
                                     Head{"\xd0\xcf\x11\xe0"sv, "a workbook of Excel (.xls)"},
                                     Head{"%PDF"sv, "a PDF document"},
                                     Head{"{\\rtf"sv, "a document in rich text format"}};
  const auto head =
      std::find_if(kHeads.begin(), kHeads.end(), [&](const Head& one) { return bytes.starts_with(one.bytes); });
  if (head != kHeads.end()) return head->name;
  return {};
}

std::uint16_t windows_1252(std::uint8_t byte) {
  static constexpr std::array<std::uint16_t, 32> kHigh{0x20ac, 0x81,   0x201a, 0x0192, 0x201e, 0x2026, 0x2020, 0x2021,
                                                       0x02c6, 0x2030, 0x0160, 0x2039, 0x0152, 0x8d,   0x017d, 0x8f,
                                                       0x90,   0x2018, 0x2019, 0x201c, 0x201d, 0x2022, 0x2013, 0x2014,
                                                       0x02dc, 0x2122, 0x0161, 0x203a, 0x0153, 0x9d,   0x017e, 0x0178};
  return byte >= 0x80 && byte < 0xa0 ? kHigh[byte - 0x80U] : byte;
}

std::string from_windows_1252(std::string_view bytes) {
  std::string out;
  out.reserve(bytes.size() + bytes.size() / 8);
  for (const char c : bytes) base::append_utf8(windows_1252(static_cast<std::uint8_t>(c)), out);
  return out;
}

std::string clean_text(std::string_view utf8, std::size_t most) {
  std::string out;
  out.reserve(std::min(utf8.size(), most));
  for (std::size_t i = 0; i < utf8.size() && out.size() <= most; ++i) {
    const auto byte = static_cast<std::uint8_t>(utf8[i]);
    if (byte == '\r') {
      if (i + 1 >= utf8.size() || utf8[i + 1] != '\n') out += '\n';
    } else {
      out += (byte < 0x20 && byte != '\n') || byte == 0x7f ? ' ' : utf8[i];
    }
  }
  if (out.size() > most) {
    out.resize(most + 1);
    while (!out.empty() && (static_cast<std::uint8_t>(out.back()) & 0xc0) == 0x80) out.pop_back();
    if (!out.empty()) out.pop_back();
  }
  const auto first = out.find_first_not_of(" \n");
  if (first == std::string::npos) return {};
  out.erase(out.find_last_not_of(" \n") + 1);
  out.erase(0, first);
  return out;
}

}  // namespace rubicon::networks::knx::groups
