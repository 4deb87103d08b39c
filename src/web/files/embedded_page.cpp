#include "web/files/embedded_page.h"

#include <algorithm>

namespace rubicon::web::files {

std::optional<Response> EmbeddedPage::find(const Request& request) const {
  const auto name = name_in(request.path);
  const auto found = std::find_if(files_.begin(), files_.end(), [&](const auto& file) { return file.name == name; });
  if (found == files_.end()) return std::nullopt;
  return answer(request, *found);
}

}  // namespace rubicon::web::files
