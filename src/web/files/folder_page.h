#pragma once

#include <string>

#include "web/files/page.h"

namespace rubicon::web::files {

/// The files of a folder, read at each request: for those who work on the page.
class FolderPage final : public Page {
 public:
  explicit FolderPage(std::string folder) : folder_(std::move(folder)) {}
  std::optional<Response> find(const Request& request) const override;

 private:
  std::string folder_;
};

}  // namespace rubicon::web::files
