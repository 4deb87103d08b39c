#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "client/target_search.h"
#include "client/tuple_query.h"
#include "web/api/context.h"
#include "web/api/route.h"
#include "web/exchange.h"

namespace rubicon::web::api {

/// Finds the tuple that a caller names as people do (docs/api.md#names-of-people), among those that it may read.
/// Destruction ends it without a call.
class NameSearch {
 public:
  using Call = std::function<void(Result<client::Target> found)>;

  /// kBusy: it counts as a list, and there were too many.
  static Result<void> allow(Context& context, const std::string& caller_name);
  /// `last`: what is meant of a point, `value` or `command`. `call` is called in a later turn, and may destroy this.
  NameSearch(Context& context, const Caller& caller, const std::string& text, std::string_view last, Call call);

 private:
  void read(const Pattern& pattern, client::TuplesCall call);

  Context& context_;
  Caller caller_;
  std::unique_ptr<client::TupleQuery> query_;
  client::TargetSearch search_;
};

// A request that names a tuple waits until it is found, and is then handled as if it had named its key.

/// For a tuple in the path; `last` as above. nullopt: it is a key already.
std::optional<std::unique_ptr<Exchange>> with_key_in_path(Call& call, std::string_view last, Handler handle);
/// For the first name among the values of a parameter of the query, `key` or `pattern`.
std::optional<std::unique_ptr<Exchange>> with_key_in_query(Call& call, std::string_view parameter, Handler handle);

}  // namespace rubicon::web::api
