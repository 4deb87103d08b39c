#pragma once

#include <functional>
#include <string>

#include "rubicon/result.hpp"

namespace rubicon::web {

/// A file with the points of an installation, as it was uploaded, or a group file with choices of the user.
struct ImportRequest {
  std::string name;      ///< of the file
  std::string content;   ///< bytes
  std::string network;   ///< whose points they become; the names and types of one that is there are kept
  std::string password;  ///< of a project; empty = none
  std::string choices;   ///< JSON object by address: {dpt, kind, leave: true}; empty = none
  bool guess = true;     ///< names decide what types do not
};

/// Says what the points of an installation become, without changing anything. The web server knows no networks: who
/// opens it has one.
class Importer {
 public:
  virtual ~Importer() = default;
  /// `done` gets JSON (docs/api.md, "Import"), in a later turn, unless the importer ends before. kBusy: it reads
  /// another file.
  virtual void preview(ImportRequest request, std::function<void(Result<std::string>)> done) = 0;
};

}  // namespace rubicon::web
