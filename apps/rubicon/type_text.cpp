#include "apps/rubicon/type_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "rubicon/unit.hpp"

namespace rubicon::cli {

namespace {

std::string bound_text(double bound) {
  return std::isfinite(bound) ? fmt::format("{}", bound) : std::string();
}

std::string between(const std::string& low, const std::string& high) {
  return low.empty() && high.empty() ? std::string() : low + ".." + high;
}

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return out;
}

/// `7`, `0x0400`.
bool is_number_of(const Type& type, std::string_view word) {
  const bool hex = word.starts_with("0x");
  const auto digits = hex ? word.substr(2) : word;
  const auto number = hex ? base::parse_hex_number<std::uint16_t>(digits) : base::parse_number<std::uint16_t>(digits);
  return number && TypeId(*number) == type.id;
}

}  // namespace

std::string range_text(const Type& type) {
  if (!type.words.empty()) {
    std::string words(type.words);
    std::replace(words.begin(), words.end(), ',', '|');
    return words;
  }
  if (type.data == model::DataType::kBoolean) return "off|on";
  return between(bound_text(type.minimum), bound_text(type.maximum));
}

std::string range_text(const model::PointDescription& description) {
  std::string words;
  for (const auto& word : description.words) words += (words.empty() ? "" : "|") + word.text;
  if (!words.empty()) return words;
  const auto bound = [](const std::optional<double>& number) { return number ? bound_text(*number) : std::string(); };
  return between(bound(description.minimum), bound(description.maximum));
}

bool found_by(const Type& type, std::string_view word) {
  const auto wanted = lower(word);
  for (const auto text : {type.name, type.quantity, type.unit}) {
    if (lower(text).find(wanted) != std::string::npos) return true;
  }
  return lower(model::unit_text(type.unit)) == wanted || is_number_of(type, word);
}

}  // namespace rubicon::cli
