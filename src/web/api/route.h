#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/compare_text.h"
#include "client/tuple_query.h"
#include "model/json_members.h"
#include "rubicon/key.hpp"
#include "verbs/members.h"
#include "web/api/context.h"
#include "web/exchange.h"

namespace rubicon::web::api {

/// Answers a request from the present tuples that match some patterns: each tuple once, by owner and key.
class TupleRead final : public Exchange {
 public:
  using Make = std::function<Response(std::vector<client::Tuple> tuples)>;
  TupleRead(Context& context, const std::vector<Pattern>& patterns, Make make, Respond respond);

 private:
  void add(std::vector<client::Tuple> some);
  void merge();

  std::vector<client::Tuple> tuples_;
  std::size_t open_ = 0;
  Make make_;
  Respond respond_;
  std::vector<std::unique_ptr<client::TupleQuery>> queries_;
};

/// A caller, as limits count it.
std::string caller_name_of(const Caller& caller);

/// One request on its way to its answer. The request lives as long as the call of its handler.
struct Call {
  Context& context;
  const Request& request;
  std::vector<std::string> parts;  ///< of the path that stand for the `{...}` of the route, decoded
  verbs::Members query;
  Respond respond;
  std::vector<std::string> keys{};  ///< texts of the request that are known to be keys, no names (naming.h)

  /// Answers with an error. nullptr.
  std::unique_ptr<Exchange> refuse(const Error& error) const;
  std::unique_ptr<Exchange> answer(Response response) const;
  /// The end of the query, then whether the caller may read what matches.
  Result<void> may_read(const Pattern& pattern);
  /// Answers with what `make` makes of the present tuples of these patterns that the caller may read. kBusy if the
  /// caller read too many; single tuples do not count.
  std::unique_ptr<Exchange> read(const std::vector<Pattern>& patterns, TupleRead::Make make) const;
  /// kBusy: the caller asked for more commands than Context::kCommandsPerSecond.
  Result<void> take_command() const;
  /// The caller, as limits count it.
  std::string caller_name() const { return caller_name_of(request.caller); }
  /// Whether the client asks for this media type.
  bool accepts(std::string_view media_type) const;
};

/// A parameter of a path or query, as the OpenAPI document describes it.
struct Parameter {
  const char* name;
  const char* type;  ///< of JSON Schema
  const char* about;
  const char* example = "";
  bool required = false;
};

struct RouteAnswer {
  unsigned status;
  const char* media_type;  ///< "" = no body
  const char* about;
};

using Handler = std::unique_ptr<Exchange> (*)(Call& call);

/// A path and method of the API.
struct Route {
  const char* method;
  const char* path;  ///< `/api/v1/things/{id}`
  const char* summary;
  Handler handle;
  std::vector<Parameter> parameters{};
  std::vector<RouteAnswer> answers{};
  const char* body = "";     ///< media type of the body of the request; "" = none
  bool is_open = false;      ///< answers callers that are not known, too
  bool takes_files = false;  ///< the body may be as long as Limits::upload, of callers with the role admin
};

/// All of them. The OpenAPI document is made of these.
std::span<const Route> routes();
/// The parts of the path for the `{...}` of the route; nullopt if it is another path, or wrongly encoded.
std::optional<std::vector<std::string>> match(const Route& route, std::string_view path);

/// `200 application/json` with the text of the tree.
Response json_response(const nlohmann::ordered_json& tree, unsigned status = 200);
/// Escapes what a query cannot hold (RFC 3986, section 2.1).
std::string percent_encoded(std::string_view text);

/// The id of a component in a path.
Result<OwnerId> owner_of(std::string_view text);
/// Descriptions and statuses of devices, and the lines of their networks.
std::vector<Pattern> device_patterns(std::optional<OwnerId> island);

// The handlers, by file.
std::unique_ptr<Exchange> describe_site(Call& call);
std::unique_ptr<Exchange> list_islands(Call& call);
std::unique_ptr<Exchange> list_devices(Call& call);
std::unique_ptr<Exchange> describe_device(Call& call);
std::unique_ptr<Exchange> list_tuples(Call& call);
std::unique_ptr<Exchange> get_tuple(Call& call);
std::unique_ptr<Exchange> put_tuple(Call& call);
std::unique_ptr<Exchange> list_inbox(Call& call);
std::unique_ptr<Exchange> decide_inbox(Call& call);
std::unique_ptr<Exchange> preview_import(Call& call);
std::unique_ptr<Exchange> list_things(Call& call);
std::unique_ptr<Exchange> describe_thing(Call& call);
std::unique_ptr<Exchange> read_history(Call& call);
std::unique_ptr<Exchange> list_series(Call& call);
std::unique_ptr<Exchange> openapi(Call& call);
std::unique_ptr<Exchange> metrics(Call& call);
std::unique_ptr<Exchange> health(Call& call);

/// Part of a list: the entries behind `after`, at most `limit`.
struct PageRange {
  static constexpr std::uint64_t kMaxCount = 1000;
  static constexpr std::size_t kMaxBytes = 1024UL * 1024;  ///< after which a page ends
  std::string after;                                       ///< `6541:proxy.wsn-1.7`; empty = from the beginning
  std::uint64_t limit = kMaxCount;
};
/// From the parameters `after` and `limit`.
PageRange read_range(verbs::Members& query);
/// The request for the next page, without scheme and host: `request` with another `after`.
std::string next_page(const Request& request, std::string_view after);

/// `{name: [...], "next": ...}`: the entries, which begin with `OWNER:KEY`, in natural order, until `limit` of them, or
/// kMaxBytes are there. `next` is missing at the end.
template <class Entry, class Name, class Form>
nlohmann::ordered_json page_of(const char* name, std::vector<Entry> entries, const Request& request,
                               const PageRange& range, Name name_of, Form form_of) {
  std::vector<std::pair<std::string, const Entry*>> named;
  named.reserve(entries.size());
  for (const auto& entry : entries) named.emplace_back(name_of(entry), &entry);
  const auto less = [](const std::string& a, const std::string& b) { return base::natural_less(a, b); };
  std::erase_if(named, [&](const auto& one) { return !range.after.empty() && !less(range.after, one.first); });
  const auto most = std::min<std::size_t>(named.size(), range.limit);
  std::partial_sort(named.begin(), named.begin() + static_cast<std::ptrdiff_t>(most), named.end(),
                    [&](const auto& a, const auto& b) { return less(a.first, b.first); });
  nlohmann::ordered_json page;
  page[name] = nlohmann::ordered_json::array();
  std::size_t count = 0;
  for (std::size_t bytes = 0; count < most && bytes < PageRange::kMaxBytes; ++count) {
    auto form = form_of(*named[count].second);
    bytes += model::dump(form).size();
    page[name].push_back(std::move(form));
  }
  if (count < named.size() && count > 0) page["next"] = next_page(request, named[count - 1].first);
  return page;
}

}  // namespace rubicon::web::api
