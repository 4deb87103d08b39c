#include "apps/rubicon/type_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "model/unit_text.h"

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
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number, hex ? 16 : 10);
  return error == std::errc() && end == digits.data() + digits.size() && TypeId(number) == type.id;
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

std::string range_text(const nlohmann::json& description) {
  const auto words = description.find("words");
  if (words != description.end() && words->is_array() && !words->empty()) {
    std::string all;
    for (const auto& word : *words) {
      if (word.is_string()) all += (all.empty() ? "" : "|") + word.get<std::string>();
    }
    return all;
  }
  const auto bound = [&description](const char* name) {
    const auto found = description.find(name);
    return found != description.end() && found->is_number() ? bound_text(found->get<double>()) : std::string();
  };
  return between(bound("minimum"), bound("maximum"));
}

bool found_by(const Type& type, std::string_view word) {
  const auto wanted = lower(word);
  for (const auto text : {type.name, type.quantity, type.unit}) {
    if (lower(text).find(wanted) != std::string::npos) return true;
  }
  return lower(model::unit_text(type.unit)) == wanted || is_number_of(type, word);
}

}  // namespace rubicon::cli
