#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "base/natural_order.h"
#include "model/json_members.h"
#include "web/api/route.h"

namespace rubicon::web::api {

/// Part of a list: the entries behind `after`, at most `limit`.
struct PageRange {
  static constexpr std::uint64_t kMost = 1000;
  static constexpr std::size_t kMaxBytes = 1024UL * 1024;  ///< after which a page ends
  std::string after;                                       ///< `6541:proxy.wsn-1.7`; empty = from the beginning
  std::uint64_t limit = kMost;
};
/// From the parameters `after` and `limit`.
PageRange read_range(Query& query);
/// The request for the next page, without scheme and host: that of `request` with another `after`.
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
