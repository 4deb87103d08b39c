#include "web/api/members.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/base64.h"
#include "base/json_depth.h"
#include "base/nearest.h"
#include "base/printable.h"
#include "model/json_members.h"
#include "model/json_text.h"

namespace rubicon::web::api {

namespace {

constexpr std::size_t kMaxDepth = 8;
constexpr std::string_view kTuple = "OWNER:KEY, such as 6541:proxy.island";

}  // namespace

Result<nlohmann::json> parse_object(std::string_view text) {
  if (base::is_nested_deeper(text, kMaxDepth))
    return fail(ErrorCode::kInvalid, fmt::format("JSON: nested deeper than {} levels", kMaxDepth));
  auto tree = model::parse_json(text);
  if (tree.is_object()) return tree;
  return fail(ErrorCode::kInvalid, fmt::format("expected a JSON object, got {}", model::quoted(text)));
}

void Members::fault(Error error) {
  if (!fault_) fault_ = Error{error.code, what_ + ": " + error.text};
}

void Members::wrong(const char* name, const nlohmann::json& got, std::string_view expected) {
  fault({ErrorCode::kInvalid,
         fmt::format("{} is {}; expected {}", name, base::printable(model::dump(got).substr(0, 60)), expected)});
}

void Members::missing(const char* name, std::string_view expected) {
  fault({ErrorCode::kInvalid, fmt::format("{} is missing; expected {}", name, expected)});
}

const nlohmann::json* Members::find(const char* name) {
  known_.emplace_back(name);
  const auto found = tree_.find(name);
  return found == tree_.end() ? nullptr : &*found;
}

std::string Members::text(const char* name, std::string_view expected) {
  const auto* got = find(name);
  if (got == nullptr) return missing(name, expected), std::string();
  if (!got->is_string()) return wrong(name, *got, expected), std::string();
  return got->get<std::string>();
}

std::string Members::text_or(const char* name, std::string default_text) {
  const auto* got = find(name);
  if (got == nullptr) return default_text;
  if (!got->is_string()) return wrong(name, *got, "a text"), default_text;
  return got->get<std::string>();
}

std::vector<std::string> Members::texts(const char* name, std::string_view expected, std::size_t most) {
  const auto* got = find(name);
  if (got == nullptr) return {};
  std::vector<std::string> list;
  const auto add = [&list](const nlohmann::json& one) {
    if (one.is_string() && !one.get_ref<const std::string&>().empty()) list.push_back(one.get<std::string>());
  };
  if (!got->is_array()) add(*got);
  if (got->is_array() && got->size() <= most) std::for_each(got->begin(), got->end(), add);
  if (!list.empty() && list.size() == (got->is_array() ? got->size() : 1)) return list;
  wrong(name, *got, fmt::format("{}, or a list of 1 to {} of them", expected, most));
  return {};
}

double Members::number_or(const char* name, double otherwise, double least, double most) {
  const auto* got = find(name);
  if (got == nullptr) return otherwise;
  const auto number = got->is_number() ? got->get<double>() : least - 1;
  if (number >= least && number <= most) return number;
  wrong(name, *got, fmt::format("a number from {} to {}", least, most));
  return otherwise;
}

std::optional<std::uint64_t> Members::count(const char* name, std::uint64_t most) {
  const auto* got = find(name);
  if (got == nullptr) return std::nullopt;
  if (got->is_number_unsigned() && got->get<std::uint64_t>() <= most) return got->get<std::uint64_t>();
  wrong(name, *got, fmt::format("a whole number from 0 to {}", most));
  return std::nullopt;
}

bool Members::flag_or(const char* name, bool otherwise) {
  const auto* got = find(name);
  if (got == nullptr) return otherwise;
  if (!got->is_boolean()) return wrong(name, *got, "true or false"), otherwise;
  return got->get<bool>();
}

Pattern Members::pattern(const char* name) {
  const auto given = text(name, "OWNER:KEY or *:KEY, such as 6541:proxy.*.*.status or *:proxy.**");
  if (fault_) return {};
  auto pattern = Pattern::parse(given);
  if (pattern) return std::move(*pattern);
  fault({ErrorCode::kInvalid, fmt::format("{}: {}", name, pattern.error().text)});
  return {};
}

Pattern Members::tuple(const char* name) {
  const auto given = text(name, kTuple);
  if (fault_) return {};
  auto tuple = Pattern::parse(given);
  if (tuple && tuple->owner && tuple->exact()) return std::move(*tuple);
  fault({ErrorCode::kInvalid, tuple ? fmt::format("{} is {}; expected {}", name, model::quoted(given), kTuple)
                                    : fmt::format("{}: {}; expected {}", name, tuple.error().text, kTuple)});
  return {};
}

std::string Members::value() {
  if (!has("b64")) return text("value", "a text, or bytes as b64");
  if (has("value")) fault({ErrorCode::kInvalid, "value and b64 exclude each other"});
  auto bytes = base::from_base64(text("b64", "bytes in base 64"));
  if (bytes) return std::move(*bytes);
  fault({ErrorCode::kInvalid, "b64: " + bytes.error().text});
  return {};
}

Result<void> Members::end() {
  if (fault_) return fail(*fault_);
  for (const auto& [name, unused] : tree_.items()) {
    if (std::find(known_.begin(), known_.end(), name) != known_.end()) continue;
    const auto near = base::did_you_mean(name, known_);
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: unknown member {}{}{}", what_, model::quoted(name), near.empty() ? "" : "; ", near));
  }
  return {};
}

}  // namespace rubicon::web::api
