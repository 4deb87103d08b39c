#pragma once

#include <string_view>

#include "tuples/member.h"

namespace rubicon::trust::rights {

/// One wish of another process and how it ended.
struct AuditLine {
  const tuples::Member& who;
  OwnerId component{};
  std::string_view host;  ///< of the component, as it declares it; for the web server the address of the caller
  std::string_view verb;  ///< set, append, approve, send, read, demand
  std::string_view key;
  std::string_view value;
  bool accepted = false;
  std::string_view why;     ///< of a refusal
  std::string_view kind{};  ///< of a refusal: its code in words, which quotes nothing
  bool quotes = false;      ///< `why` is of the owner of the tuple and may quote the value
};

/// Where wishes are recorded.
class Audit {
 public:
  virtual ~Audit() = default;
  virtual void write(const AuditLine& line) = 0;
};

}  // namespace rubicon::trust::rights
