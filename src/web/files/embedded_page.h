#pragma once

#include <vector>

#include "web/files/file_answer.h"
#include "web/files/page.h"

namespace rubicon::web::files {

/// web/dist as it was when the program was built; written by cmake/embed_page.cmake.
std::vector<File> embedded_files();

/// The page in the program.
class EmbeddedPage final : public Page {
 public:
  explicit EmbeddedPage(std::vector<File> files = embedded_files()) : files_(std::move(files)) {}
  std::optional<Response> find(const Request& request) const override;

 private:
  std::vector<File> files_;
};

}  // namespace rubicon::web::files
