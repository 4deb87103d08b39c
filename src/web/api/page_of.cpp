#include "web/api/page_of.h"

namespace rubicon::web::api {

PageRange read_range(Query& query) {
  return {query.text("after"), query.count("limit", PageRange::kMost, 1, PageRange::kMost)};
}

std::string next_page(const Request& request, std::string_view after) {
  auto target = request.path + "?";
  for (const auto& [name, value] : request.query) {
    if (name != "after") target += percent_encoded(name) + "=" + percent_encoded(value) + "&";
  }
  return target + "after=" + percent_encoded(after);
}

}  // namespace rubicon::web::api
