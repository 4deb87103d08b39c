#include "island/own_tuples.h"

#include <fmt/format.h>

#include <set>
#include <tuple>

#include "rubicon/key.hpp"

namespace rubicon::island {

namespace {

Result<OwnTuple> read_one(const std::string& text, std::string_view prefix) {
  const auto wrong = [&text](std::string_view why) {
    return fail(ErrorCode::kInvalid, fmt::format("--tuple {}: {}", model::quoted(text), why));
  };
  const auto equals = text.find('=');
  if (equals == text.npos) return wrong("expected KEY=VALUE");
  OwnTuple tuple{text.substr(0, equals), text.substr(equals + 1)};
  if (const auto good = model::check_key(tuple.key); !good) return wrong(good.error().text);
  const auto first = model::key_parts(tuple.key).front();
  if (first == prefix || first == "GATEWAY" || first == "RUBICON_GATEWAY" || first == "ROAMING")
    return wrong(fmt::format("the island keeps the tuples of {} itself", first));
  return tuple;
}

}  // namespace

Result<std::vector<OwnTuple>> read_own_tuples(const std::vector<std::string>& texts, std::string_view prefix) {
  std::vector<OwnTuple> tuples;
  std::set<std::string> keys;
  for (const auto& text : texts) {
    auto tuple = read_one(text, prefix);
    if (!tuple) return fail(std::move(tuple.error()));
    if (!keys.insert(tuple->key).second)
      return fail(ErrorCode::kInvalid, fmt::format("--tuple {}: its key is given twice", model::quoted(text)));
    tuples.push_back(std::move(*tuple));
  }
  return tuples;
}

void OwnTuples::start() {
  for (const auto& tuple : tuples_) {
    judges_.push_back(space_.add_policy({space_.self(), tuple.key},
                                        [](const tuples::RemoteSet&) { return tuples::SetDecision::applied(); }));
    std::ignore = space_.set(tuple.key, tuple.value, {"text/plain"});
  }
}

}  // namespace rubicon::island
