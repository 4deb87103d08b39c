#include "trust/guard/refusal.h"

#include <dds/ddsrt/heap.h>
#include <dds/ddsrt/string.h>

#include <algorithm>
#include <cstring>

namespace rubicon::trust::guard {

void explain(DDS_Security_SecurityException* exception, const std::string& name, const std::string& reason) {
  if (exception == nullptr) return;
  clear(*exception);
  const auto text = "Rubicon guard: " + (name.empty() ? "a peer" : name) + ": " + reason;
  exception->message = ddsrt_strdup(text.c_str());
  exception->code = DDS_SECURITY_ERR_ACCESS_DENIED_CODE;
  exception->minor_code = 0;
}

std::string reason_of(const DDS_Security_SecurityException* exception) {
  constexpr std::size_t kLongest = 256;
  if (exception == nullptr || exception->message == nullptr) return "no reason was given";
  std::string text(exception->message, ::strnlen(exception->message, kLongest));
  std::ranges::replace_if(
      text, [](char c) { return c < ' ' || c > '~'; }, ' ');
  return text;
}

void clear(DDS_Security_SecurityException& exception) {
  ddsrt_free(exception.message);
  exception = {};
}

}  // namespace rubicon::trust::guard
