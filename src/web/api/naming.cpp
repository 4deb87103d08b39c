#include "web/api/naming.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace rubicon::web::api {

namespace {

constexpr Duration kSearchTime = std::chrono::seconds(3);

}  // namespace

Result<void> NameSearch::allow(Context& context, const std::string& caller_name) {
  if (!context.lists.take(caller_name, context.scheduler.now()))
    return fail(ErrorCode::kBusy, fmt::format("more than {} names or lists in a second", Context::kListsPerSecond));
  for (const auto& pattern : client::name_patterns()) context.recent_reads.keep(pattern);
  return {};
}

NameSearch::NameSearch(Context& context, const Caller& caller, const std::string& text, std::string_view last,
                       Call call)
    : context_(context),
      caller_(caller),
      search_(
          client::islands_in(context.space), text, std::string(last),
          [this](const Pattern& pattern, client::TuplesCall tuples) { read(pattern, std::move(tuples)); },
          [text, call = std::move(call)](Result<client::Findings> found) {
            call(found ? client::the_one(*found, text) : fail(found.error()));
          }) {
  search_.start();
}

void NameSearch::read(const Pattern& pattern, client::TuplesCall call) {
  auto readable = [this, call = std::move(call)](std::vector<client::Tuple> tuples) {
    const auto cost = static_cast<double>(tuples.size()) / Context::kTuplesOfAList;
    context_.lists.charge(caller_name_of(caller_), context_.scheduler.now(), cost);
    const auto& permission = context_.permission;
    if (!permission.sees_all(caller_))
      std::erase_if(tuples, [&](const auto& one) { return !permission.access(caller_, one.key).read; });
    call(std::move(tuples));  // may destroy this
  };
  query_ = std::make_unique<client::TupleQuery>(context_.scheduler, context_.space, context_.peers, pattern,
                                                std::move(readable), kSearchTime);
}

namespace {

/// Where the name stands: in the path, or the number of a parameter.
using Place = std::optional<std::size_t>;

class NamedExchange final : public Exchange {
 public:
  NamedExchange(const Call& call, Place place, const std::string& text, std::string_view last, Handler handle)
      : context_(call.context),
        request_(call.request),
        parts_(call.parts),
        keys_(call.keys),
        respond_(call.respond),
        place_(place),
        text_(text),
        handle_(handle),
        search_(call.context, call.request.caller, text, last,
                [this](const Result<client::Target>& found) { take(found); }) {}

 private:
  void take(const Result<client::Target>& found) {
    const bool is_pattern = place_ && request_.query[*place_].first == "pattern" && Pattern::parse(text_);
    if (!found && (!is_pattern || found.error().code != ErrorCode::kNotFound))
      return respond_(error_response(found.error()));  // may destroy this
    found ? put(*found) : keys_.push_back(text_);
    Call again{context_, request_, parts_, verbs::Members(request_.query), respond_, keys_};
    const auto watch = lifetime_.watch();
    auto inner = handle_(again);
    if (!watch.ended()) inner_ = std::move(inner);
  }

  void put(const client::Target& found) {
    keys_.push_back(to_string(found));
    if (place_) {
      request_.query[*place_].second = keys_.back();
    } else {
      parts_ = {std::to_string(number(found.owner)), found.key};
    }
  }

  Context& context_;
  Request request_;
  std::vector<std::string> parts_, keys_;
  Respond respond_;
  Place place_;
  std::string text_;
  Handler handle_;
  std::unique_ptr<Exchange> inner_;
  base::Lifetime lifetime_;
  NameSearch search_;
};

bool is_known(const Call& call, const std::string& text) {
  return std::find(call.keys.begin(), call.keys.end(), text) != call.keys.end();
}

std::unique_ptr<Exchange> with_key(Call& call, Place place, const std::string& text, std::string_view last,
                                   Handler handle) {
  if (auto good = NameSearch::allow(call.context, call.caller_name()); !good) return call.refuse(good.error());
  return std::make_unique<NamedExchange>(call, place, text, last, handle);
}

}  // namespace

std::optional<std::unique_ptr<Exchange>> with_key_in_path(Call& call, std::string_view last, Handler handle) {
  const auto text = call.parts[0] == "*" ? call.parts[1] : call.parts[0] + ":" + call.parts[1];
  if (is_known(call, text) || !client::is_name(call.context.space, text)) return std::nullopt;
  return with_key(call, {}, text, last, handle);
}

std::optional<std::unique_ptr<Exchange>> with_key_in_query(Call& call, std::string_view parameter, Handler handle) {
  const auto is_name = parameter == "pattern" ? client::is_name_among_patterns : client::is_name;
  const auto& query = call.request.query;
  for (std::size_t i = 0; i < query.size(); ++i) {
    const auto& [name, text] = query[i];
    if (name == parameter && !is_known(call, text) && is_name(call.context.space, text))
      return with_key(call, i, text, "value", handle);
  }
  return std::nullopt;
}

}  // namespace rubicon::web::api
