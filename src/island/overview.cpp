#include "island/overview.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "base/bytes.h"
#include "base/text.h"
#include "model/json_members.h"

namespace rubicon::island {

namespace {

using nlohmann::json;

constexpr std::string_view kNothing = R"({"names":{},"pins":[],"rooms":[]})";
/// Where the state file keeps it, beside what networks remember: no network has such an id.
constexpr const char* kKeeper = "(island)";
constexpr const char* kKeptAs = "overview";
constexpr std::size_t kDeepest = 2;

bool is_text(const json& value) {
  const auto* text = value.is_string() ? value.get_ptr<const std::string*>() : nullptr;
  return text && text->size() <= Overview::kMaxText && base::is_utf8(*text) &&
         std::none_of(text->begin(), text->end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; });
}

bool is_list(const json& value) {
  return value.is_array() && std::all_of(value.begin(), value.end(), is_text);
}

bool is_names(const json& value) {
  if (!value.is_object()) return false;
  return std::all_of(value.items().begin(), value.items().end(),
                     [](const auto& one) { return is_text(json(one.key())) && is_text(one.value()); });
}

/// Lists take the place of those before; each name is set, "" removes it.
bool merge(const std::string& member, const json& value, json& into) {
  if (member == "names" && is_names(value)) {
    auto& names = into["names"];
    for (const auto& [key, name] : value.items()) name == "" ? void(names.erase(key)) : void(names[key] = name);
    return true;
  }
  if ((member != "rooms" && member != "pins") || !is_list(value)) return false;
  into[member] = value;
  return true;
}

tuples::SetDecision refused(ErrorCode code, std::string why) {
  return tuples::SetDecision::refused({code, std::move(why)});
}

}  // namespace

Overview::Overview(TupleSpace& space, const std::string& prefix, state::StateStore* store)
    : space_(space), key_(prefix + ".overview"), store_(store), text_(kNothing) {
  const auto kept = store_ ? store_->remembered(kKeeper, kKeptAs) : Result<std::optional<Bytes>>(std::nullopt);
  if (kept && *kept) text_.assign((*kept)->begin(), (*kept)->end());
  show();
  policy_ = space_.add_policy({space_.self(), key_},
                              [this](const tuples::RemoteSet& request) { return decide(request.value); });
}

void Overview::show() {
  std::ignore = space_.set(key_, text_, {"application/json", {}, {}});
}

tuples::SetDecision Overview::decide(std::string_view text) {
  if (!store_) {
    return refused(ErrorCode::kRefused,
                   "this island has no state file (`state:` in its configuration): the overview would be lost");
  }
  const auto change = base::is_nested_deeper(text, kDeepest) ? json() : model::parse_json(text);
  auto next = model::object_of(text_);
  bool good = change.is_object() && !change.empty();
  if (good) {
    for (const auto& [member, value] : change.items()) good = good && merge(member, value, next);
  }
  if (!good) {
    return refused(
        ErrorCode::kInvalid,
        fmt::format(R"({}: expected one or more of {{"rooms": [TEXT], "pins": [KEY], "names": {{KEY: TEXT}}}})"
                    ", texts of at most {} bytes",
                    key_, kMaxText));
  }
  auto fresh = model::dump(next);
  if (fresh.size() > kMaxBytes)
    return refused(ErrorCode::kOutOfRange,
                   fmt::format("{}: {} bytes, at most {} are kept", key_, fresh.size(), kMaxBytes));
  if (auto done = store_->remember(kKeeper, kKeptAs, base::as_bytes(fresh), 1); !done)
    return refused(done.error().code, done.error().text);
  text_ = std::move(fresh);
  show();
  return tuples::SetDecision::consumed();
}

}  // namespace rubicon::island
