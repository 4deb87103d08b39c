#pragma once

#include <filesystem>
#include <string>

namespace rubicon::bench::trust {

/// A realm in a folder of its own, which goes with it. Ends the process with a message if there can be none.
class Realm {
 public:
  Realm();
  ~Realm();
  Realm(const Realm&) = delete;
  Realm& operator=(const Realm&) = delete;

  std::string folder() const { return (parent_ / "trust").string(); }

 private:
  std::filesystem::path parent_;
};

}  // namespace rubicon::bench::trust
